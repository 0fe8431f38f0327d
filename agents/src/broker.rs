//! The broker: all agents together, around one set of books.
//!
//! It reads what the books need to know *before* a step, carries out the
//! increments that the step asks for before it leaves the books, and does
//! everything slow after it has left them. So no thread ever holds two of our
//! locks, and who waits at a gate keeps nobody from the books.

mod asks;
mod redeclare;
mod service;
mod supervise;

use core::fmt;

use faregate_tickets::amount::{Microjoules, Milligrams, Milliwatts};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Device, Estimate};
use faregate_tickets::gate::{Key, KeyOf};
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::lock::{Exclusion, Strategy};
use faregate_tickets::notify::Notify;
use faregate_tickets::platform::Platform;
use faregate_tickets::recorder::{Lane, Record, RecordedEvent, Unrecorded};
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::Standing;
use faregate_tickets::ticket::{Holder, Issuer, Seat};

use crate::books::{Actions, Books, DeviceReport, Event, Noted};
use crate::limits::{MAX_AGENTS, MAX_GATES};
use crate::policy::{Categories, Policy};
use crate::refusal::Waiting;

pub use asks::{Handle, Want, Wants};
pub use supervise::{NotQuiescent, NotYours, Quiescent, Revoked, Supervisor};

/// All ticket agents of a spacecraft, for up to `G` gates, `T` tickets and `S`
/// sets of them.
///
/// It is put together alone (`&mut`): agents, gates, supervisors. Then it is
/// shared, and no gate, agent or supervisor can be added any more.
pub struct Broker<'g, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize> {
    tag: usize,
    keys: heapless::Vec<Key<'g>, G>,
    /// The agent of each gate, by number.
    agents_of_gates: heapless::Vec<u8, G>,
    scope: Scope,
    agents: [Scope; MAX_AGENTS],
    standings: [Standing; T],
    ledger: <P::Strategy as Strategy>::Lock<Ledger<P, G, T, S>>,
    notify: N,
}

/// What is behind the broker's lock.
struct Ledger<P: Platform, const G: usize, const T: usize, const S: usize> {
    books: Books<G, T, S>,
    clock: P::Clock,
    lane: P::Lane,
    /// What the latest step asked for.
    actions: Actions<G>,
    /// Tickets that became valid, were revoked or ended, to be notified by the
    /// next service, which has been asked for.
    changed: heapless::Vec<Changed, CHANGED>,
}

/// A ticket of which somebody is to be told.
#[derive(Clone, Copy)]
enum Changed {
    GrantedOrEnded(TicketId),
    Revoked(TicketId),
}

impl Changed {
    fn tell(self, notify: &impl Notify) {
        match self {
            Self::GrantedOrEnded(ticket) => notify.ticket_changed(ticket),
            Self::Revoked(ticket) => notify.ticket_revoked(ticket),
        }
    }
}

/// What one step can change, twice over.
const CHANGED: usize = 4 * MAX_GATES;

/// Why an agent or a gate could not be registered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RegisterError {
    /// All agents or gates that the broker has room for are there.
    NoCapacity,
    /// There is no such agent.
    UnknownAgent,
}

impl fmt::Display for RegisterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoCapacity => "the broker is full; build it with more",
            Self::UnknownAgent => "there is no such agent at this broker",
        })
    }
}

impl core::error::Error for RegisterError {}

/// An agent's number at its broker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AgentId {
    tag: usize,
    pub(crate) number: u8,
}

impl<'g, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Broker<'g, P, N, G, T, S>
{
    /// A broker without agents. `lane` is its own lane in the flight recorder.
    pub fn new(clock: P::Clock, lane: P::Lane, notify: N) -> Self {
        let books = Books::new(clock.now());
        Self {
            tag: next_tag(),
            keys: heapless::Vec::new(),
            agents_of_gates: heapless::Vec::new(),
            scope: Scope::new(),
            agents: core::array::from_fn(|_| Scope::new()),
            standings: core::array::from_fn(|_| Standing::new()),
            ledger: Exclusion::new(Ledger {
                books,
                clock,
                lane,
                actions: Actions::new(),
                changed: heapless::Vec::new(),
            }),
            notify,
        }
    }

    /// Adds an agent.
    ///
    /// # Errors
    /// [`RegisterError::NoCapacity`].
    pub fn agent(&mut self, policy: Policy) -> Result<AgentId, RegisterError> {
        let number = self.enter(|ledger| ledger.books.add_agent(policy)).flatten();
        let tag = self.tag;
        number.map(|number| AgentId { tag, number }).ok_or(RegisterError::NoCapacity)
    }

    /// Gives a gate to an agent, which swallows its key. The device is orphaned
    /// and charged until it is seen off.
    ///
    /// # Errors
    /// [`RegisterError`].
    pub fn register<D: Device, Q: Platform>(
        &mut self,
        agent: AgentId,
        key: KeyOf<'g, D, Q>,
    ) -> Result<Handle<'g, D, Q>, RegisterError> {
        self.register_with_categories(agent, key, Categories::NONE)
    }

    /// Like [`Broker::register`], for a device that has conflict categories.
    ///
    /// # Errors
    /// [`RegisterError`].
    pub fn register_with_categories<D: Device, Q: Platform>(
        &mut self,
        agent: AgentId,
        key: KeyOf<'g, D, Q>,
        categories: Categories,
    ) -> Result<Handle<'g, D, Q>, RegisterError> {
        if agent.tag != self.tag {
            return Err(RegisterError::UnknownAgent);
        }
        let (key, handle) = key.split();
        let profile = *key.profile();
        let added = self.enter(|ledger| {
            let now = ledger.clock.now();
            ledger.books.step(Event::Tick(now), &mut ledger.actions);
            ledger.books.add_gate(agent.number, profile, categories)
        });
        let gate = added.flatten().ok_or(RegisterError::NoCapacity)?;
        self.keys.push(key).map_err(|_| RegisterError::NoCapacity)?;
        self.agents_of_gates.push(agent.number).map_err(|_| RegisterError::NoCapacity)?;
        Ok(Handle::new(self.tag, gate, agent.number, handle))
    }

    /// The sensors' word on a device. Its measurement counts, not its arrival.
    /// One from the future, and one about a gate that is not here, is ignored.
    ///
    /// # Timing
    /// One step of the books; what follows from it is for the next service.
    pub fn observe(&self, gate: GateId, estimate: Estimate) {
        // Where the books cannot be entered, nothing is credited.
        let _ = self.tell(Event::Observed(gate, estimate));
    }

    /// What a ticket waits for; `None` if it waits for nothing.
    ///
    /// # Timing
    /// One entry into the books: waits at most for one step of them.
    pub fn waiting_for(&self, ticket: TicketId) -> Option<Waiting> {
        self.enter(|ledger| ledger.books.waiting_for(ticket)).flatten()
    }

    /// What the books know of a device.
    ///
    /// # Timing
    /// One entry into the books: waits at most for one step of them.
    pub fn device(&self, gate: GateId) -> Option<DeviceReport> {
        self.enter(|ledger| ledger.books.device_report(gate)).flatten()
    }

    /// The agent's supply, and the sum of its charges, where it has a margin.
    ///
    /// # Timing
    /// One entry into the books: waits at most for one step of them.
    pub fn margin(&self, agent: AgentId) -> Option<(Milliwatts, Milliwatts)> {
        let number = Some(agent.number).filter(|_| agent.tag == self.tag)?;
        self.enter(|ledger| {
            let books = &ledger.books;
            books.supply(number).map(|supply| (supply, books.charged(number)))
        })
        .flatten()
    }

    /// The energy and the propellant that the agent can still promise. What is
    /// promised and not used comes back when its device is seen off.
    ///
    /// # Timing
    /// One entry into the books: waits at most for one step of them.
    pub fn budgets(&self, agent: AgentId) -> Option<(Microjoules, Milligrams)> {
        let number = Some(agent.number).filter(|_| agent.tag == self.tag)?;
        self.enter(|ledger| ledger.books.budgets(number)).flatten()
    }

    /// The computed bound of a hand-over; see [`Books::hand_over_bound`].
    ///
    /// # Timing
    /// One entry into the books: waits at most for one step of them.
    pub fn hand_over_bound(&self, gate: GateId, rounds: u32) -> Option<Duration> {
        self.enter(|ledger| ledger.books.hand_over_bound(gate, rounds)).flatten()
    }

    /// A copy of the books, for tests and displays.
    ///
    /// # Timing
    /// Copies all of them inside the books' lock: not for a flight loop.
    pub fn books(&self) -> Option<Books<G, T, S>> {
        self.enter(|ledger| ledger.books.clone())
    }

    /// How many seats are free.
    ///
    /// # Timing
    /// One entry into the books: waits at most for one step of them.
    pub fn free_seats(&self) -> Option<usize> {
        self.enter(|ledger| ledger.books.free_seats())
    }

    /// The present instant, by the broker's clock.
    ///
    /// # Timing
    /// One entry into the books: waits at most for one step of them.
    pub fn now(&self) -> Option<Instant> {
        self.enter(|ledger| ledger.clock.now())
    }

    /// An event that somebody outside brings.
    fn tell(&self, event: Event) -> Option<()> {
        let told = self.enter(|ledger| {
            let now = ledger.clock.now();
            ledger.books.steps([Event::Tick(now), event], &mut ledger.actions);
            self.carry_out(ledger, now);
        });
        self.notify.service_due();
        told
    }

    /// Alone with the ledger. There is nobody to tell if that fails: the lock's
    /// owner died inside, or this is a call from inside.
    fn enter<R>(&self, f: impl FnOnce(&mut Ledger<P, G, T, S>) -> R) -> Option<R> {
        self.ledger.with(f).ok()
    }

    /// What the step asked for at once: increments, and records.
    fn carry_out(&self, ledger: &mut Ledger<P, G, T, S>, now: Instant) {
        let Ledger { actions, changed, lane, .. } = ledger;
        let mut note = |change: Changed| {
            if changed.push(change).is_err() {
                // More than fits between two services: better under the lock
                // than not at all.
                change.tell(&self.notify);
            }
        };
        for ticket in actions.granted.iter().chain(&actions.ended) {
            note(Changed::GrantedOrEnded(*ticket));
        }
        for (ticket, _) in actions.revoked.iter().chain(&actions.explained) {
            note(Changed::Revoked(*ticket));
        }
        // What was granted in this step may have been revoked in it.
        for ticket in &actions.granted {
            lane.record(Record::of(now, *ticket, RecordedEvent::Granted));
        }
        for (ticket, why) in &actions.revoked {
            self.with_standing(ticket.seat, |standing| standing.revoke(*why));
            lane.record(Record::of(now, *ticket, RecordedEvent::Revoked(*why)));
        }
        for (ticket, why) in &actions.explained {
            self.with_standing(ticket.seat, |standing| {
                standing.explain_now(standing.epoch_seen(), *why)
            });
            lane.record(Record::of(now, *ticket, RecordedEvent::Revoked(*why)));
        }
        for ticket in &actions.ended {
            self.with_standing(ticket.seat, Standing::end);
            lane.record(Record::of(now, *ticket, RecordedEvent::Ended));
        }
        for noted in &actions.noted {
            let event = match *noted {
                Noted::SeenOff(gate) => RecordedEvent::SeenOff { gate },
                Noted::Stuck(gate) => RecordedEvent::Stuck { gate },
                Noted::Faulted(gate, fault) => RecordedEvent::Faulted { gate, fault },
            };
            lane.record(Record { at: now, ticket: 0, event });
        }
    }

    fn with_standing(&self, seat: u16, f: impl FnOnce(&Standing)) {
        if let Some(standing) = self.standings.get(usize::from(seat)) {
            f(standing);
        }
    }

    fn key(&self, gate: GateId) -> Option<&Key<'g>> {
        self.keys.get(usize::from(gate.0))
    }
}

impl<P: Platform, N: Notify, const G: usize, const T: usize, const S: usize> Issuer
    for Broker<'_, P, N, G, T, S>
{
    fn relinquish(&self, seat: &Seat<'_>, counted: Unrecorded, holder: Holder) {
        // Only tickets made here point to this scope.
        if !core::ptr::eq(seat.broker, &self.scope) {
            return;
        }
        let (ticket, gate) = (seat.id, seat.gate);
        self.enter(|ledger| {
            let now = ledger.clock.now();
            for event in counted.events().into_iter().flatten() {
                ledger.lane.record(Record::of(now, ticket, event));
            }
            ledger.lane.record(Record::of(now, ticket, RecordedEvent::Relinquished));
            ledger.books.relinquished(ticket, gate, holder, &mut ledger.actions);
            self.carry_out(ledger, now);
        });
        self.notify.service_due();
    }
}

impl<P: Platform, N: Notify, const G: usize, const T: usize, const S: usize> fmt::Debug
    for Broker<'_, P, N, G, T, S>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Broker").field("gates", &self.keys.len()).finish_non_exhaustive()
    }
}

/// Tells brokers apart, so that a handle, an agent or a supervisor of another
/// one is refused.
fn next_tag() -> usize {
    static NEXT: portable_atomic::AtomicUsize = portable_atomic::AtomicUsize::new(1);
    // Relaxed: only that no two are the same.
    NEXT.fetch_add(1, portable_atomic::Ordering::Relaxed)
}
