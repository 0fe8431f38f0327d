//! All interleavings of three clients, two service threads, and the sensors,
//! around the production books.
//!
//! A service thread picks a piece of work, does it at the gate, and reports it:
//! three steps, between which anything can happen. Gates and standings are the
//! few words of theirs that matter here, as plain data, so that a state can be
//! compared and counted.

#![cfg(not(loom))]

use faregate_agents::{
    Actions, Ask, Books, Categories, DeviceState, Done, Event, Noted, Policy, Work,
};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::{Estimate, Power, Profile};
use faregate_tickets::gate::{Blocked, Safed, Vacated};
use faregate_tickets::id::{GateId, Priority, TicketId};
use faregate_tickets::validity::Validity;
use stateright::{Checker, HasDiscoveries, Model, Property};

/// What each client asks for, all or nothing.
struct Client {
    gates: &'static [usize],
    priority: u8,
}

const CLIENTS: [Client; 3] = [
    Client { gates: &[0], priority: 1 },
    Client { gates: &[1], priority: 2 },
    Client { gates: &[1, 2], priority: 3 },
];
const DRAWS: [u64; 3] = [2, 2, 3];
const SUPPLY: u64 = 5;
const LAG: Duration = Duration::from_millis(1);
/// How often the sensors are read, or fail to be, in one run. (Without
/// optimisation twice takes minutes.)
const MEASUREMENTS: u8 = if cfg!(debug_assertions) { 1 } else { 2 };

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Gate {
    tenant: usize,
    tenure: usize,
    vacated: (usize, u64),
    safed: (u8, u64),
    may_be_on: bool,
    is_on: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Thread {
    Free,
    Picked(Work),
    Did(Done),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Holder {
    Absent,
    Holds { ticket: TicketId, commanded: bool },
    Gone,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct World {
    mutant: Mutant,
    books: Books<3, 3, 1>,
    now: u64,
    gates: [Gate; 3],
    /// Epoch and stamp of each seat.
    standings: [(usize, usize); 3],
    threads: [Thread; 2],
    holders: [Holder; 3],
    measurements: u8,
    /// To the next safing command.
    deaf: bool,
    /// By our own account: nobody can free these.
    stuck: [bool; 3],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Act {
    Request(usize),
    TurnOn(usize),
    Relinquish(usize),
    Step(usize),
    Measure(usize),
    /// Whatever was to be confirmed by now was not.
    TimePasses,
}

/// A break that must be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Mutant {
    None,
    /// Leaves out the increments that revoke.
    Unrevoked,
    /// Says that a device is off which was only told to go off.
    BelievedOff,
}

struct Clients(Mutant);

impl World {
    /// Two of the clients have what they asked for, and it is on.
    fn new(mutant: Mutant) -> Self {
        let mut books = Books::new(Instant::START);
        let agent = books.add_agent(Policy::power_margin(Milliwatts::new(SUPPLY))).unwrap();
        for draw in DRAWS {
            let mut profile = Profile::new().drawing(Milliwatts::new(draw));
            (profile.safing_attempts, profile.estimate_lag) = (1, LAG);
            books.add_gate(agent, profile, Categories::NONE).unwrap();
        }
        let mut world = Self {
            mutant,
            books,
            now: 1,
            gates: Default::default(),
            standings: [(1, 0); 3],
            threads: [Thread::Free, Thread::Free],
            holders: [Holder::Absent; 3],
            measurements: 0,
            deaf: false,
            stuck: [false; 3],
        };
        for gate in 0..DRAWS.len() {
            world.measure(gate);
        }
        world.measurements = 0;
        world.request(0);
        world.request(1);
        while let Ok(work) = world.books.work() {
            let done = world.perform(work);
            world.feed(Event::Done(done));
        }
        world.turn_on(0);
        world.turn_on(1);
        world
    }

    fn turn_on(&mut self, client: usize) {
        for gate in CLIENTS[client].gates {
            (self.gates[*gate].is_on, self.gates[*gate].may_be_on) = (true, true);
        }
        if let Holder::Holds { commanded, .. } = &mut self.holders[client] {
            *commanded = true;
        }
    }

    fn feed(&mut self, event: Event) {
        let now = Instant::from_micros(self.now);
        let before: Vec<_> = (0..3).map(|gate| self.state(gate)).collect();
        let mut actions = Actions::default();
        self.books.steps([Event::Tick(now), event], &mut actions);
        for (gate, before) in before.into_iter().enumerate() {
            // Whoever used it may have freed it.
            self.stuck[gate] &= before != DeviceState::Leaving || self.state(gate) == before;
        }
        self.carry_out(&actions);
    }

    fn carry_out(&mut self, actions: &Actions<3>) {
        for noted in &actions.noted {
            match *noted {
                Noted::SeenOff(gate) => self.stuck[usize::from(gate.0)] = false,
                Noted::Stuck(gate) => self.stuck[usize::from(gate.0)] = true,
                Noted::Faulted(..) => {}
            }
        }
        let ended = actions.ended.iter();
        let revoked = actions.revoked.iter().map(|(ticket, _)| ticket);
        let revoked = revoked.filter(|_| self.mutant != Mutant::Unrevoked);
        for ticket in revoked.chain(ended) {
            self.standings[usize::from(ticket.seat)].0 += 1;
        }
    }

    fn measure(&mut self, gate: usize) {
        self.now += 1;
        self.measurements += 1;
        let on = self.gates[gate].is_on && self.mutant != Mutant::BelievedOff;
        let state = if on { Power::On } else { Power::Off };
        let measured_at = Instant::from_micros(self.now);
        let gate = GateId(u8::try_from(gate).unwrap());
        self.feed(Event::Observed(gate, Estimate { state, measured_at }));
    }

    fn is_valid(&self, ticket: TicketId, gate: usize) -> bool {
        let (epoch, stamp) = self.standings[usize::from(ticket.seat)];
        self.gates[gate].tenant == ticket.serial && epoch == stamp
    }

    /// As a gate does it.
    fn perform(&mut self, work: Work) -> Done {
        let id = work.gate();
        let now = self.now;
        let gate = &mut self.gates[usize::from(id.0)];
        let stale = |tenure| Done::Blocked { gate: id, tenure, blocked: Blocked::Stale };
        match work {
            Work::Vacate { tenure, .. } => {
                let done = gate.tenant == 0 && gate.vacated.0 == tenure && gate.tenure != tenure;
                if !done {
                    let admitted_since = gate.tenant != 0 && gate.tenure == tenure + 1;
                    if gate.tenure != tenure && !admitted_since {
                        return stale(tenure);
                    }
                    (gate.tenant, gate.tenure) = (0, gate.tenure + 1);
                    (gate.vacated, gate.safed) = ((tenure, now), (0, now));
                }
                let vacated = Vacated {
                    tenure: gate.tenure,
                    at: Instant::from_micros(gate.vacated.1),
                    latest_tenant: 0,
                    validity: Validity::always(),
                    may_be_on: gate.may_be_on,
                };
                Done::Vacated { gate: id, ended: tenure, vacated }
            }
            Work::Safe { tenure, attempt, .. } => {
                let (tried, at) = gate.safed;
                if gate.tenure != tenure || (tried != attempt && tried + 1 != attempt) {
                    return stale(tenure);
                }
                let at = if tried == attempt { at } else { now };
                if tried != attempt {
                    gate.safed = (attempt, now);
                    gate.is_on &= std::mem::take(&mut self.deaf);
                }
                let safed = Safed { at: Instant::from_micros(at) };
                Done::Safed { gate: id, tenure, attempt, safed }
            }
            Work::SeenOff { tenure, at, .. } => {
                if gate.tenure != tenure {
                    return stale(tenure);
                }
                gate.may_be_on &= gate.is_on;
                Done::SeenOff { gate: id, at }
            }
            Work::Admit { tenure, ticket, stamp, .. } => {
                let again = gate.tenant == ticket.serial && gate.tenure == tenure + 1;
                if !again && gate.tenure != tenure {
                    return stale(tenure);
                }
                if !again {
                    (gate.tenant, gate.tenure, gate.safed) = (ticket.serial, tenure + 1, (0, now));
                    if let Some(stamp) = stamp {
                        self.standings[usize::from(ticket.seat)].1 = stamp.own;
                    }
                }
                Done::Admitted { gate: id, after: tenure, tenure: tenure + 1, ticket }
            }
        }
    }

    fn request(&mut self, client: usize) {
        let Client { gates, priority } = &CLIENTS[client];
        let id = |gate: usize| GateId(u8::try_from(gate).unwrap());
        let mut ask = Ask::new(Priority::new(*priority), id(gates[0]), Validity::always());
        for gate in &gates[1..] {
            ask = ask.and(id(*gate), Validity::always()).unwrap();
        }
        let mut actions = Actions::default();
        let ticket = self.books.request(&ask, &mut actions).unwrap();
        self.carry_out(&actions);
        self.holders[client] = Holder::Holds { ticket, commanded: false };
    }

    fn step(&mut self, thread: usize) {
        let next = match self.threads[thread].clone() {
            Thread::Free => self.books.work().map_or(Thread::Free, Thread::Picked),
            Thread::Picked(work) => Thread::Did(self.perform(work)),
            Thread::Did(done) => {
                self.feed(Event::Done(done));
                Thread::Free
            }
        };
        self.threads[thread] = next;
    }

    fn holds(&self) -> impl Iterator<Item = (usize, TicketId)> {
        self.holders.iter().enumerate().filter_map(|(client, holder)| match holder {
            Holder::Holds { ticket, .. } => Some((client, *ticket)),
            _ => None,
        })
    }

    fn state(&self, gate: usize) -> DeviceState {
        self.books.device_report(GateId(u8::try_from(gate).unwrap())).unwrap().state
    }

    /// Margin Kept, of the devices themselves.
    fn draws_within_supply(&self) -> bool {
        let on = self.gates.iter().zip(DRAWS).filter(|(gate, _)| gate.is_on);
        on.map(|(_, draw)| draw).sum::<u64>() <= SUPPLY
    }

    /// Margin Kept, in the books: and what is on is charged.
    fn charges_are_true(&self) -> bool {
        let charged =
            |(gate, it): (usize, &Gate)| !it.is_on || self.state(gate) != DeviceState::Off;
        self.books.charged(0).get() <= SUPPLY && self.gates.iter().enumerate().all(charged)
    }

    /// All or nothing: who is valid at one gate is valid at each of its gates,
    /// or has been pre-empted already and is being put out.
    fn valid_alone(&self) -> bool {
        let valid = self.holds().filter(|(client, ticket)| {
            let gates = CLIENTS[*client].gates;
            gates.iter().any(|gate| self.is_valid(*ticket, *gate))
        });
        let mut taken: Vec<usize> = Vec::new();
        for (client, ticket) in valid {
            let gates = CLIENTS[client].gates;
            if !gates.iter().all(|gate| self.is_valid(ticket, *gate)) {
                return false;
            }
            taken.extend(gates);
        }
        let sum: u64 = taken.iter().map(|gate| DRAWS[*gate]).sum();
        taken.sort_unstable();
        taken.windows(2).all(|two| two[0] != two[1]) && sum <= SUPPLY
    }

    /// Closed Door: nobody is valid whom the books have not granted.
    fn door_is_closed(&self) -> bool {
        self.holds().all(|(client, ticket)| {
            let mut gates = CLIENTS[client].gates.iter();
            let valid = gates.any(|gate| self.is_valid(ticket, *gate));
            !valid || !matches!(self.books.waiting_for(ticket), Some(waiting) if waiting != faregate_agents::Waiting::HandOver)
        })
    }

    fn is_quiet(&self) -> bool {
        let idle = self.threads.iter().all(|thread| *thread == Thread::Free);
        idle && self.books.work() == Err(None)
    }

    /// Highest First: in a quiet state, valid are those that fit beside all
    /// more important ones.
    fn highest_first(&self) -> bool {
        if !self.is_quiet() {
            return true;
        }
        let stuck: Vec<usize> = (0..3).filter(|gate| self.stuck[*gate]).collect();
        let mut order: Vec<_> = self.holds().collect();
        order.sort_by_key(|(client, ticket)| (255 - CLIENTS[*client].priority, ticket.serial));
        let mut used = stuck.clone();
        let mut taken: Vec<usize> = Vec::new();
        order.into_iter().all(|(client, ticket)| {
            let gates = CLIENTS[client].gates;
            let mut sum: Vec<usize> = used.iter().chain(gates).copied().collect();
            sum.sort_unstable();
            sum.dedup();
            let free = gates.iter().all(|gate| !taken.contains(gate));
            let fits = sum.iter().map(|gate| DRAWS[*gate]).sum::<u64>() <= SUPPLY;
            if free && fits {
                taken.extend(gates);
                used = sum;
            }
            self.books.is_valid(ticket) == (free && fits)
        })
    }
}

impl Model for Clients {
    type State = World;
    type Action = Act;

    fn init_states(&self) -> Vec<World> {
        let mut deaf = World::new(self.0);
        deaf.deaf = true;
        vec![World::new(self.0), deaf]
    }

    fn actions(&self, world: &World, acts: &mut Vec<Act>) {
        for (client, holder) in world.holders.iter().enumerate() {
            match *holder {
                Holder::Absent => acts.push(Act::Request(client)),
                Holder::Holds { ticket, commanded } => {
                    let mut gates = CLIENTS[client].gates.iter();
                    if !commanded && gates.all(|gate| world.is_valid(ticket, *gate)) {
                        acts.push(Act::TurnOn(client));
                    }
                    acts.push(Act::Relinquish(client));
                }
                Holder::Gone => {}
            }
        }
        for (thread, it) in world.threads.iter().enumerate() {
            if *it != Thread::Free || world.books.work().is_ok() {
                acts.push(Act::Step(thread));
            }
        }
        let confirming = |gate: &usize| world.state(*gate) == DeviceState::Confirming;
        if world.measurements < MEASUREMENTS {
            acts.extend((0..3).filter(confirming).map(Act::Measure));
        }
        if world.measurements < MEASUREMENTS {
            acts.extend((0..3).find(confirming).map(|_| Act::TimePasses));
        }
    }

    fn next_state(&self, world: &World, act: Act) -> Option<World> {
        let mut world = world.clone();
        match act {
            Act::Request(client) => world.request(client),
            Act::TurnOn(client) => world.turn_on(client),
            Act::Relinquish(client) => {
                let Holder::Holds { ticket, .. } = world.holders[client] else { return None };
                for gate in CLIENTS[client].gates {
                    let gate = GateId(u8::try_from(*gate).unwrap());
                    let mut actions = Actions::default();
                    let lives = faregate_tickets::ticket::Holder::Lives;
                    world.books.relinquished(ticket, gate, lives, &mut actions);
                    world.carry_out(&actions);
                }
                world.feed(Event::Tick(Instant::START));
                world.holders[client] = Holder::Gone;
            }
            Act::Step(thread) => world.step(thread),
            Act::Measure(gate) => world.measure(gate),
            Act::TimePasses => {
                world.now += LAG.as_micros() + 1;
                world.measurements += 1;
                world.feed(Event::Tick(Instant::START));
            }
        }
        Some(world)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always("Margin Kept: draws", |_, world: &World| world.draws_within_supply()),
            Property::always("Margin Kept: charges", |_, world: &World| world.charges_are_true()),
            Property::always("One Tenant, all or nothing", |_, world: &World| world.valid_alone()),
            Property::always("Closed Door", |_, world: &World| world.door_is_closed()),
            Property::always("Highest First", |_, world: &World| world.highest_first()),
            Property::sometimes("a stuck device", |_, world: &World| world.stuck.contains(&true)),
            Property::sometimes("all have come, and it is quiet", |_, world: &World| {
                world.is_quiet() && world.holds().count() == CLIENTS.len()
            }),
        ]
    }

    fn within_boundary(&self, _: &World) -> bool {
        true
    }
}

#[test]
fn the_promises_hold_in_every_interleaving() {
    let checker = Clients(Mutant::None).checker().threads(2).spawn_bfs().join();
    println!("{} states, {} of them distinct", checker.state_count(), checker.unique_state_count());
    checker.assert_properties();
}

/// Whether a mutant breaks this promise. Others may be broken before it: the
/// search goes on until it has found this one.
fn breaks(mutant: Mutant, promise: &'static str) -> bool {
    let found = HasDiscoveries::AllOf([promise].into());
    let checker = Clients(mutant).checker().threads(2).finish_when(found);
    checker.spawn_bfs().join().discovery(promise).is_some()
}

#[test]
fn a_revocation_without_its_increment_is_found_out() {
    assert!(breaks(Mutant::Unrevoked, "Closed Door"));
}

#[test]
fn a_device_that_is_only_believed_off_is_found_out() {
    assert!(breaks(Mutant::BelievedOff, "Margin Kept: charges"));
}
