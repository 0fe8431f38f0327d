//! An agent's books: plain data with one step function.
//!
//! [`Books::step`] takes an event and answers what is to be done about it; it
//! reads no clock and touches no gate. What is slow is offered by
//! [`Books::work`], done by whoever asks, and reported as an event. The broker
//! around the books, the model checker and the random histories of the tests
//! all drive this same step.
//!
//! All agents of a broker share one set of books, and so one lock: arbitration
//! is one total order over all of them, and nothing can deadlock.

mod actions;
mod arbitrate;
mod device;
mod grant;
mod handover;
mod notice;
mod redeclare;
mod report;
mod seats;

use faregate_tickets::amount::{Microjoules, Milligrams, Milliwatts};
use faregate_tickets::clock::Instant;
use faregate_tickets::device::{Estimate, Profile};
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::scope::Seen;
use faregate_tickets::ticket::Holder;

use crate::limits::{LARGEST_SUPPLY, MAX_AGENTS, MAX_GATES, MAX_SEATS};
use crate::policy::{Categories, Policy};
use crate::refusal::RequestRefused;
use crate::roster::Rosters;

pub use actions::{Actions, List, Noted};
use device::DeviceBook;
use grant::{Grant, SetBook};
pub use handover::{Done, Work};
pub use redeclare::Redeclared;
pub use report::{DeviceReport, DeviceState};
pub use seats::Ask;

/// Books for up to `G` gates, `T` tickets and `S` sets of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Books<const G: usize, const T: usize, const S: usize> {
    agents: heapless::Vec<AgentBook, MAX_AGENTS>,
    devices: heapless::Vec<DeviceBook, G>,
    grants: [Grant; T],
    sets: [SetBook; S],
    rosters: Rosters<G, T>,
    free: u16,
    /// How many seats are taken.
    seated: u16,
    next_serial: usize,
    next_arrival: u64,
    broker_seen: Seen,
    now: Instant,
}

/// What the books know of one agent.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct AgentBook {
    policy: Policy,
    /// The present supply, where the policy has a margin.
    supply: Milliwatts,
    /// The largest supply so far: what exceeds it can never be granted.
    largest_supply: Milliwatts,
    energy_left: Microjoules,
    propellant_left: Milligrams,
    seen: Seen,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// Time has passed until now.
    Tick(Instant),
    /// The epochs and floors as they are now, each epoch read before its floor.
    Noticed {
        /// The broker's.
        broker: Seen,
        /// The agents', by number.
        agents: [Seen; MAX_AGENTS],
        /// The gates whose tenant made the broker's latest epoch itself.
        survivors: u64,
    },
    /// A ticket was given back, or one gate of its set.
    Relinquished {
        /// Which ticket.
        ticket: TicketId,
        /// Which gate of it.
        gate: GateId,
        /// What became of its holder.
        holder: Holder,
    },
    /// A supervisor barred the grant in this seat.
    Barred {
        /// The seat.
        seat: u16,
        /// Its own epoch now.
        epoch: usize,
    },
    /// The grant in this seat was hit by a bar that meant an earlier one.
    HitByStaleBar {
        /// The seat.
        seat: u16,
        /// Its own epoch now.
        epoch: usize,
    },
    /// A supervisor reinstated a barred ticket.
    Reinstated(TicketId),
    /// The sensors measured a device.
    Observed(GateId, Estimate),
    /// The agent's supply changed.
    Supply {
        /// The agent, by number.
        agent: u8,
        /// The supply from now on.
        supply: Milliwatts,
    },
    /// A limit of a tenant has run out.
    RanOut {
        /// The tenant's gate.
        gate: GateId,
        /// The tenant's serial.
        serial: usize,
        /// Whether the ticket has ended with it, or only rests.
        ends_ticket: bool,
    },
    /// The gates' faults, as they are now.
    Faults([Option<GateFault>; MAX_GATES]),
    /// A supervisor reset a faulted gate.
    Reset(GateId),
    /// A piece of work was done, or could not be.
    Done(Done),
}

impl<const G: usize, const T: usize, const S: usize> Books<G, T, S> {
    const CAPACITIES: () = {
        assert!(G >= 1 && G <= MAX_GATES, "gates are kept in the bits of one word");
        assert!(T >= 1 && T <= MAX_SEATS, "seats are linked by 16-bit numbers");
        assert!(S <= MAX_GATES, "the table of candidates has room for so many sets");
    };

    /// Empty books, at this instant.
    #[must_use]
    pub fn new(now: Instant) -> Self {
        let () = Self::CAPACITIES;
        Self {
            agents: heapless::Vec::new(),
            devices: heapless::Vec::new(),
            grants: core::array::from_fn(Grant::free),
            sets: core::array::from_fn(|_| SetBook::default()),
            rosters: Rosters::new(),
            free: 0,
            seated: 0,
            next_serial: 1,
            next_arrival: 1,
            broker_seen: Seen { epoch: 1, floor: 0 },
            now,
        }
    }

    /// Adds an agent; answers its number, or `None` if there is no room.
    pub fn add_agent(&mut self, policy: Policy) -> Option<u8> {
        let supply = policy.supply.unwrap_or_default().min(LARGEST_SUPPLY);
        let number = u8::try_from(self.agents.len()).ok()?;
        let book = AgentBook {
            policy,
            supply,
            largest_supply: supply,
            energy_left: policy.energy.unwrap_or_default(),
            propellant_left: policy.propellant.unwrap_or_default(),
            seen: Seen { epoch: 1, floor: 0 },
        };
        self.agents.push(book).ok().map(|()| number)
    }

    /// Adds a gate to an agent; answers its number, or `None` if there is no
    /// room or no such agent. Its device is orphaned: charged until seen off.
    pub fn add_gate(
        &mut self,
        agent: u8,
        profile: Profile,
        categories: Categories,
    ) -> Option<GateId> {
        self.agents.get(usize::from(agent))?;
        let number = u8::try_from(self.devices.len()).ok()?;
        let mut book = DeviceBook::new(agent, profile, categories, self.now);
        if !self.is_charged(&book) && !book.must_safe && !book.is_safed_unless_held() {
            book.settle_uncharged();
        }
        self.devices.push(book).ok().map(|()| GateId(number))
    }

    /// Takes an event in, and decides anew. What is to be done about it is in
    /// `actions` afterwards, and nothing else.
    ///
    /// # Timing
    /// Bounded by the gates and sets.
    pub fn step(&mut self, event: Event, actions: &mut Actions<G>) {
        self.steps([event], actions);
    }

    /// Takes events in that came together, and decides anew once.
    ///
    /// # Timing
    /// As [`Books::step`], for each event.
    pub fn steps(&mut self, events: impl IntoIterator<Item = Event>, actions: &mut Actions<G>) {
        actions.clear();
        for event in events {
            self.take_in(event, actions);
        }
        self.end_what_is_over(actions);
        self.arbitrate(actions);
    }

    /// Takes a request in, and decides anew.
    ///
    /// # Errors
    /// [`RequestRefused`], and the books are as they were.
    ///
    /// # Timing
    /// As [`Books::step`].
    pub fn request(
        &mut self,
        ask: &Ask,
        actions: &mut Actions<G>,
    ) -> Result<TicketId, RequestRefused> {
        actions.clear();
        let ticket = self.seat(ask)?;
        self.arbitrate(actions);
        Ok(ticket)
    }

    /// Takes back a ticket, or one gate of its set. Nothing is decided: that is
    /// for the next step, and not for whoever drops a ticket.
    ///
    /// # Timing
    /// Bounded by the gates of the ticket's own grant.
    pub fn relinquished(
        &mut self,
        ticket: TicketId,
        gate: GateId,
        holder: Holder,
        actions: &mut Actions<G>,
    ) {
        actions.clear();
        self.relinquish(ticket, gate, holder, actions);
    }

    /// Takes an event in, and leaves it to the next step to decide anew.
    pub(crate) fn taken_in(&mut self, event: Event, actions: &mut Actions<G>) {
        actions.clear();
        self.take_in(event, actions);
    }

    fn take_in(&mut self, event: Event, actions: &mut Actions<G>) {
        match event {
            Event::Tick(now) => self.tick(now, actions),
            Event::Noticed { broker, agents, survivors } => {
                self.notice(broker, &agents, survivors, actions);
            }
            Event::Relinquished { ticket, gate, holder } => {
                self.relinquish(ticket, gate, holder, actions);
            }
            Event::Barred { seat, epoch } => self.bar(seat, epoch, actions),
            Event::HitByStaleBar { seat, epoch } => self.hit_by_stale_bar(seat, epoch, actions),
            Event::Reinstated(ticket) => self.reinstate(ticket),
            Event::Observed(gate, estimate) => self.observe(gate, estimate, actions),
            Event::Supply { agent, supply } => self.set_supply(agent, supply),
            Event::RanOut { gate, serial, ends_ticket } => {
                self.run_out(gate, serial, ends_ticket, actions);
            }
            Event::Faults(faults) => self.notice_faults(&faults, actions),
            Event::Reset(gate) => self.reset(gate),
            Event::Done(done) => self.done(done, actions),
        }
    }

    pub(crate) fn agent(&self, number: u8) -> Option<&AgentBook> {
        self.agents.get(usize::from(number))
    }

    pub(crate) fn device(&self, gate: GateId) -> Option<&DeviceBook> {
        self.devices.get(usize::from(gate.0))
    }

    fn device_mut(&mut self, gate: GateId) -> Option<&mut DeviceBook> {
        self.devices.get_mut(usize::from(gate.0))
    }

    pub(crate) fn grant(&self, seat: u16) -> Option<&Grant> {
        self.grants.get(usize::from(seat)).filter(|grant| grant.serial != 0)
    }

    fn grant_mut(&mut self, seat: u16) -> Option<&mut Grant> {
        self.grants.get_mut(usize::from(seat)).filter(|grant| grant.serial != 0)
    }

    /// The grant of a ticket, unless the id is stale.
    fn grant_of(&self, ticket: TicketId) -> Option<&Grant> {
        self.grant(ticket.seat).filter(|grant| grant.serial == ticket.serial)
    }

    /// Whether a device counts against its agent's supply or categories.
    fn is_charged(&self, device: &DeviceBook) -> bool {
        let Some(agent) = self.agent(device.agent) else { return false };
        let draws = agent.policy.supply.is_some() && !device.profile.draw.is_zero();
        draws || (agent.policy.categories && !device.categories.is_empty())
    }
}

/// The gates whose bits are set, in order.
pub(crate) fn gates_of(mut bits: u64) -> impl Iterator<Item = GateId> {
    core::iter::from_fn(move || {
        let gate = u8::try_from(bits.trailing_zeros()).ok().filter(|gate| *gate < 64)?;
        bits &= bits - 1;
        Some(GateId(gate))
    })
}

/// A gate's bit.
pub(crate) const fn bit(gate: GateId) -> u64 {
    1 << (gate.0 & 63)
}
