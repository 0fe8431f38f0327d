//! What can happen in a history.

use std::sync::atomic::Ordering::Relaxed;

use faregate_agents::{Ask, Categories, Event, Redeclared};
use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::GateId;
use faregate_tickets::validity::{Function, Validity};

use super::lamp::Switch;
use super::world::{Declared, Granted, World};

/// A history, printed with one happening on a line.
#[derive(Clone)]
pub(crate) struct History(pub(crate) Vec<Step>);

impl std::fmt::Debug for History {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|step| write!(f, "\n  {step:?},"))
    }
}

/// One happening. Numbers pick among what there is.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    Request {
        gates: Vec<u8>,
        priority: u8,
        limit: Limit,
    },
    Relinquish {
        ticket: u8,
        gate: u8,
    },
    Extend {
        ticket: u8,
        gate: u8,
    },
    Command {
        ticket: u8,
        gate: u8,
        on: bool,
    },
    DriverFault {
        ticket: u8,
    },
    /// The supervisor's increment, and its being noted.
    Bar {
        ticket: u8,
    },
    /// A bar that meant the seat's earlier grant.
    StaleBar {
        seat: u8,
    },
    Reinstate {
        ticket: u8,
    },
    Supply {
        agent: u8,
        supply: u64,
    },
    EnterSafeMode {
        scope: u8,
        floor: u8,
    },
    LeaveSafeMode {
        scope: u8,
    },
    RevokeAllButMe {
        ticket: u8,
        floor: u8,
    },
    Pass {
        ms: u8,
    },
    /// The sensors measure; the word arrives now, or later, or is "unknown".
    Measure {
        gate: u8,
        word: Word,
    },
    MeasureAll {
        word: Word,
    },
    LateEstimate {
        which: u8,
    },
    Deaf {
        gate: u8,
        times: u8,
    },
    Hang {
        gate: u8,
        hung: bool,
    },
    Reset {
        gate: u8,
    },
    /// Something else turns the device on.
    Unbidden {
        gate: u8,
    },
    /// Another draw, other categories, and a longer time to settle.
    Redeclare {
        gate: u8,
        draw: u64,
        categories: u8,
        longer_ms: u64,
    },
    Look,
    Work {
        how: How,
    },
    Report {
        which: u8,
    },
    /// Work that was offered earlier is done now.
    LateWork {
        which: u8,
        how: How,
    },
    Service,
    /// Time, sensors and service, until nothing moves.
    Settle,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limit {
    None,
    Invocations,
    Energy,
    ShortLease,
    DutyCycle,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Word {
    Prompt,
    Late,
    Unknown,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum How {
    Well,
    Twice,
    /// Done, and the report is held back.
    Unreported,
    /// Offered, and nobody does it yet.
    NotYet,
}

const INVOCATIONS: u32 = 2;

impl Limit {
    fn validity(self) -> Validity {
        let function = match self {
            Self::None => Function::always(),
            Self::Invocations => Function::invocations(INVOCATIONS),
            Self::Energy => Function::energy(Microjoules::new(300)),
            Self::ShortLease => Function::lease(Duration::from_millis(15)),
            Self::DutyCycle => {
                let (on, period) = (Duration::from_millis(5), Duration::from_millis(20));
                Function::duty_cycle(on, period).unwrap()
            }
        };
        function.into()
    }
}

impl World<'_> {
    fn gate(&self, number: u8) -> GateId {
        GateId(number % u8::try_from(self.keys.len()).unwrap())
    }

    fn agent(&self, number: u8) -> u8 {
        number % u8::try_from(self.ground.setup.agents.len()).unwrap()
    }

    pub(crate) fn apply(&mut self, step: &Step) {
        match *step {
            Step::Request { ref gates, priority, limit } => self.request(gates, priority, limit),
            Step::Relinquish { ticket, gate } => {
                if let Some(serial) = self.pick(ticket) {
                    self.relinquish(serial, gate);
                }
            }
            Step::Extend { ticket, gate } => self.extend(ticket, self.gate(gate)),
            Step::Command { ticket, gate, on } => {
                self.command(ticket, gate, if on { Switch::On } else { Switch::Off });
            }
            Step::DriverFault { ticket } => self.command(ticket, 0, Switch::Fault),
            Step::Pass { ms } => {
                self.ground.clock.advance(Duration::from_millis(ms.into()));
            }
            Step::Supply { agent, supply } => {
                let agent = self.agent(agent);
                self.supply[usize::from(agent)] = supply;
                let supply = Milliwatts::new(supply);
                self.feed(Event::Supply { agent, supply });
            }
            Step::Look => self.look(),
            Step::Service => {
                self.service();
            }
            Step::Settle => {
                if self.unreported.is_empty() {
                    self.settle();
                    self.check_chosen();
                }
            }
            ref other => self.apply_to_outside(other),
        }
    }

    fn apply_to_outside(&mut self, step: &Step) {
        match *step {
            Step::Bar { ticket } => {
                if let Some(serial) = self.pick(ticket) {
                    let seat = self.grants[&serial].id.seat;
                    self.standing(seat).bar(serial);
                    self.ground.broker.note_bar(seat);
                }
            }
            Step::StaleBar { seat } => {
                let seat = u16::from(seat) % u16::try_from(super::world::SEATS).unwrap();
                self.standing(seat).bar(usize::MAX);
                self.ground.broker.note_bar(seat);
            }
            Step::Reinstate { ticket } => self.reinstate(ticket),
            Step::EnterSafeMode { scope, floor } => {
                self.scope(scope).enter_safe_mode(Self::priority(floor));
            }
            Step::LeaveSafeMode { scope } => self.scope(scope).leave_safe_mode(),
            Step::RevokeAllButMe { ticket, floor } => self.revoke_all_but_me(ticket, floor),
            Step::Measure { gate, word } => self.measured(self.gate(gate), word),
            Step::MeasureAll { word } => {
                self.gate_ids().for_each(|gate| self.measured(gate, word));
            }
            Step::LateEstimate { which } => {
                if !self.late_estimates.is_empty() {
                    let which = usize::from(which) % self.late_estimates.len();
                    let (gate, estimate) = self.late_estimates.remove(which);
                    self.observe(gate, estimate);
                }
            }
            Step::Deaf { gate, times } => {
                let truth = &self.ground.truths[usize::from(self.gate(gate).0)];
                truth.deaf_to_safing.store(times.into(), Relaxed);
            }
            Step::Hang { gate, hung } => {
                let truth = &self.ground.truths[usize::from(self.gate(gate).0)];
                truth.hung.store(hung, Relaxed);
            }
            Step::Reset { gate } => {
                let gate = self.gate(gate);
                self.keys[usize::from(gate.0)].reopen();
                self.stuck[usize::from(gate.0)] = false;
                // Before it is fed: what is checked then was decided without it.
                self.faults[usize::from(gate.0)] = false;
                self.feed(Event::Reset(gate));
            }
            Step::Unbidden { gate } => {
                let truth = &self.ground.truths[usize::from(self.gate(gate).0)];
                if !truth.draws(self.now()) {
                    truth.turn(true, self.now());
                    truth.unbidden.store(true, Relaxed);
                }
            }
            Step::Redeclare { gate, draw, categories, longer_ms } => {
                self.redeclare(self.gate(gate), draw, categories, longer_ms);
            }
            ref other => self.apply_to_work(other),
        }
    }

    fn redeclare(&mut self, gate: GateId, draw: u64, categories: u8, longer_ms: u64) {
        let number = usize::from(gate.0);
        let old = self.declared(number);
        // The lamp itself settles as it always did: to declare less would lie.
        let settles_ms = self.ground.setup.devices[number].settling_ms;
        let new = Declared { draw, categories, settling_ms: settles_ms + longer_ms, ..old };
        let declared = Redeclared {
            draw: Milliwatts::new(draw),
            categories: Categories::from_mask(categories.into()),
            settling: new.profile().settling,
            estimate_lag: new.profile().estimate_lag,
        };
        let before = self.books.clone();
        let done = self.books.redeclare(gate, &declared);
        let named = self.grants.values().find(|grant| grant.gates().any(|it| it == number));
        match (done, named) {
            (Ok(()), None) => self.declared[number] = new,
            (Ok(()), Some(grant)) => panic!("{gate} was declared anew under {}", grant.id),
            (Err(_), _) => assert_eq!(self.books, before, "nothing changes when it is refused"),
        }
        self.check_charges();
    }

    fn apply_to_work(&mut self, step: &Step) {
        match *step {
            Step::Work { how } => {
                if let Ok(work) = self.books.work() {
                    self.work(work, how);
                }
            }
            Step::LateWork { which, how } => {
                if !self.late_work.is_empty() {
                    let which = usize::from(which) % self.late_work.len();
                    let work = self.late_work.remove(which);
                    self.work(work, how);
                }
            }
            Step::Report { which } => {
                if !self.unreported.is_empty() {
                    let which = usize::from(which) % self.unreported.len();
                    let done = self.unreported.remove(which);
                    self.report(done);
                }
            }
            _ => unreachable!("all others are applied already"),
        }
    }

    fn work(&mut self, work: faregate_agents::Work, how: How) {
        if how == How::NotYet {
            self.late_work.push(work);
            return;
        }
        let done = self.perform(&work);
        match how {
            How::Unreported => self.unreported.push(done),
            How::Twice => {
                let again = self.perform(&work);
                self.report(done);
                self.report(again);
            }
            _ => self.report(done),
        }
    }

    fn request(&mut self, gates: &[u8], priority: u8, limit: Limit) {
        let mut distinct: Vec<GateId> = Vec::new();
        for gate in gates.iter().map(|gate| self.gate(*gate)) {
            if !distinct.contains(&gate) {
                distinct.push(gate);
            }
        }
        let mut ask = Ask::new(Self::priority(priority), distinct[0], limit.validity());
        for gate in &distinct[1..] {
            ask = ask.and(*gate, limit.validity()).unwrap();
        }
        let mut actions = faregate_agents::Actions::default();
        self.books.step(Event::Tick(self.now()), &mut actions);
        self.carry_out(&actions);
        let before = self.books.clone();
        let Ok(id) = self.books.request(&ask, &mut actions) else {
            assert_eq!(self.books, before, "a refused request changes nothing");
            return;
        };
        self.standing(id.seat).seat(id.serial, self.books.agents_of(id));
        self.arrivals += 1;
        let granted = Granted {
            id,
            priority,
            arrival: self.arrivals,
            barred: false,
            resting: false,
            exempt: false,
            has_budget: limit == Limit::Energy,
            on_commands_left: (limit == Limit::Invocations && distinct.len() == 1)
                .then_some((distinct[0], INVOCATIONS)),
            tickets: distinct.iter().map(|gate| (*gate, self.ticket(id, *gate))).collect(),
        };
        self.grants.insert(id.serial, granted);
        self.carry_out(&actions);
    }

    pub(crate) fn relinquish(&mut self, serial: usize, gate: u8) {
        let grant = self.grants.get_mut(&serial).unwrap();
        let which = usize::from(gate) % grant.tickets.len();
        let (gate, _) = grant.tickets.remove(which);
        let id = grant.id;
        let over = grant.tickets.is_empty();
        let mut actions = faregate_agents::Actions::default();
        self.books.relinquished(id, gate, faregate_tickets::ticket::Holder::Lives, &mut actions);
        let ended = actions.ended.iter().any(|ended| *ended == id);
        assert_eq!(over, ended, "over with its last ticket");
        self.carry_out(&actions);
    }

    fn extend(&mut self, ticket: u8, gate: GateId) {
        let Some(serial) = self.pick(ticket) else { return };
        let id = self.grants[&serial].id;
        let before = self.books.clone();
        let mut actions = faregate_agents::Actions::default();
        if self.books.extend(id, gate, Validity::always(), &mut actions).is_err() {
            assert_eq!(self.books, before, "a refused extension changes nothing");
            return;
        }
        let ticket = self.ticket(id, gate);
        self.grants.get_mut(&serial).unwrap().tickets.push((gate, ticket));
        self.carry_out(&actions);
        self.standing(id.seat).set_agents(self.books.agents_of(id));
    }

    fn command(&mut self, ticket: u8, gate: u8, command: Switch) {
        let Some(serial) = self.pick(ticket) else { return };
        let grant = self.grants.get_mut(&serial).unwrap();
        let which = usize::from(gate) % grant.tickets.len();
        let (gate, ticket) = &grant.tickets[which];
        if self.ground.truths[usize::from(gate.0)].hung.load(Relaxed) {
            return;
        }
        let issued = ticket.invoke(command).is_ok();
        if issued && command == Switch::On {
            self.budget_used |= grant.has_budget;
            if let Some((_, left)) = grant.on_commands_left.as_mut().filter(|(of, _)| of == gate) {
                *left = left.checked_sub(1).expect("a limit on use holds from ticket to ticket");
            }
        }
    }

    fn reinstate(&mut self, ticket: u8) {
        let Some(serial) = self.pick(ticket) else { return };
        self.look();
        let Some(grant) = self.grants.get_mut(&serial) else { return };
        let id = grant.id;
        if std::mem::take(&mut grant.barred) {
            self.arrivals += 1;
            grant.arrival = self.arrivals;
        }
        self.standing(id.seat).forget_bar();
        self.feed(Event::Reinstated(id));
    }

    fn scope(&self, number: u8) -> &faregate_tickets::scope::Scope {
        let number = usize::from(number) % (1 + self.ground.scopes.len());
        number.checked_sub(1).map_or(&self.ground.broker, |agent| &self.ground.scopes[agent])
    }

    fn revoke_all_but_me(&mut self, ticket: u8, floor: u8) {
        let Some(serial) = self.pick(ticket) else { return };
        let grant = self.grants.get_mut(&serial).unwrap();
        let ticket = &grant.tickets[0].1;
        grant.exempt = ticket.revoke_all_but_me(&self.ground.broker, Self::priority(floor));
    }

    fn measured(&mut self, gate: GateId, word: Word) {
        let mut estimate = self.measure(gate);
        match word {
            Word::Prompt => self.observe(gate, estimate),
            Word::Late => self.late_estimates.push((gate, estimate)),
            Word::Unknown => {
                estimate = Estimate { state: Power::Unknown, ..estimate };
                self.observe(gate, estimate);
            }
        }
    }
}
