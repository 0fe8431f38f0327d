//! Requests: one gate, or several all or nothing, in the types of their
//! devices.

mod lists;

use core::fmt;

use faregate_tickets::clock::Clock;
use faregate_tickets::device::Device;
use faregate_tickets::gate::Handle as GateHandle;
use faregate_tickets::id::{GateId, HolderId, Priority, TicketId};
use faregate_tickets::lock::Exclusion;
use faregate_tickets::notify::Notify;
use faregate_tickets::platform::Platform;
use faregate_tickets::recorder::{Lane, Record, RecordedEvent};
use faregate_tickets::ticket::{Seat, Ticket};
use faregate_tickets::validity::Validity;

use crate::books::{Ask, Event};
use crate::refusal::RequestRefused;

use super::Broker;

/// Names a registered gate in requests, and what its device is. No authority
/// comes with it.
pub struct Handle<'g, D: Device, P: Platform> {
    tag: usize,
    gate: GateId,
    agent: u8,
    handle: GateHandle<'g, D, P>,
}

impl<'g, D: Device, P: Platform> Handle<'g, D, P> {
    pub(super) fn new(tag: usize, gate: GateId, agent: u8, handle: GateHandle<'g, D, P>) -> Self {
        Self { tag, gate, agent, handle }
    }

    /// The gate's number, for estimates and reports.
    #[must_use]
    pub fn gate(&self) -> GateId {
        self.gate
    }

    /// The gate, with this validity function.
    #[must_use]
    pub fn limited(&self, validity: impl Into<Validity>) -> Want<'g, D, P> {
        Want { handle: *self, validity: validity.into(), holder: HolderId::UNNAMED }
    }
}

impl<D: Device, P: Platform> Clone for Handle<'_, D, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D: Device, P: Platform> Copy for Handle<'_, D, P> {}

impl<D: Device, P: Platform> fmt::Debug for Handle<'_, D, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Handle").field(&self.gate).finish()
    }
}

/// A gate in a request, with the validity function that its ticket is to have.
pub struct Want<'g, D: Device, P: Platform> {
    handle: Handle<'g, D, P>,
    validity: Validity,
    holder: HolderId,
}

impl<D: Device, P: Platform> Want<'_, D, P> {
    /// For this holder, whose tickets a supervisor can bar together. In a set
    /// the first member's holder counts.
    #[must_use]
    pub fn held_by(mut self, holder: HolderId) -> Self {
        self.holder = holder;
        self
    }
}

impl<D: Device, P: Platform> fmt::Debug for Want<'_, D, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Want").field("gate", &self.handle.gate).finish_non_exhaustive()
    }
}

/// What can be requested: a handle, a [`Want`], or several wants, which are
/// granted all or nothing: a tuple of them answers a tuple of tickets, a
/// [`heapless::Vec`] of equal ones a list, and a want beside a list both.
pub trait Wants<'b, 'g: 'b, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
{
    /// The tickets, one for each gate.
    type Tickets;

    /// What the books are asked for.
    ///
    /// # Errors
    /// A gate of another broker, a gate twice, or too many.
    fn ask(
        &self,
        broker: &Broker<'g, P, N, G, T, S>,
        priority: Priority,
    ) -> Result<Ask, RequestRefused>;

    /// The tickets of a new grant; `None` for a foreign gate.
    fn tickets(
        &self,
        broker: &'b Broker<'g, P, N, G, T, S>,
        seated: &Seated,
    ) -> Option<Self::Tickets>;
}

/// A grant that has got its seat and not yet its tickets.
///
/// Only [`Broker::request`] makes one, and nobody else can name it: so nobody
/// has tickets made a second time for a grant whose id they know, and only the
/// types of this module can be requested.
#[derive(Debug)]
pub struct Seated(TicketId);

impl<
    'b,
    'g: 'b,
    D: Device,
    Q: Platform,
    P: Platform + 'b,
    N: Notify + 'b,
    const G: usize,
    const T: usize,
    const S: usize,
> Wants<'b, 'g, P, N, G, T, S> for Want<'g, D, Q>
{
    type Tickets = Ticket<'b, D, Q, Broker<'g, P, N, G, T, S>>;

    fn ask(
        &self,
        broker: &Broker<'g, P, N, G, T, S>,
        priority: Priority,
    ) -> Result<Ask, RequestRefused> {
        let gate = broker.known(&self.handle)?;
        Ok(Ask::new(priority, gate, self.validity).held_by(self.holder))
    }

    fn tickets(
        &self,
        broker: &'b Broker<'g, P, N, G, T, S>,
        seated: &Seated,
    ) -> Option<Self::Tickets> {
        broker.ticket(&self.handle, seated.0)
    }
}

impl<
    'b,
    'g: 'b,
    D: Device,
    Q: Platform,
    P: Platform + 'b,
    N: Notify + 'b,
    const G: usize,
    const T: usize,
    const S: usize,
> Wants<'b, 'g, P, N, G, T, S> for Handle<'g, D, Q>
{
    type Tickets = Ticket<'b, D, Q, Broker<'g, P, N, G, T, S>>;

    fn ask(
        &self,
        broker: &Broker<'g, P, N, G, T, S>,
        priority: Priority,
    ) -> Result<Ask, RequestRefused> {
        self.limited(Validity::always()).ask(broker, priority)
    }

    fn tickets(
        &self,
        broker: &'b Broker<'g, P, N, G, T, S>,
        seated: &Seated,
    ) -> Option<Self::Tickets> {
        broker.ticket(self, seated.0)
    }
}

macro_rules! tuple_of_wants {
    ($($device:ident $platform:ident $field:tt),+) => {
        impl<'b, 'g: 'b, $($device: Device, $platform: Platform,)+
            P: Platform + 'b, N: Notify + 'b, const G: usize, const T: usize, const S: usize>
            Wants<'b, 'g, P, N, G, T, S> for ($(Want<'g, $device, $platform>,)+)
        {
            type Tickets = ($(Ticket<'b, $device, $platform, Broker<'g, P, N, G, T, S>>,)+);

            fn ask(
                &self,
                broker: &Broker<'g, P, N, G, T, S>,
                priority: Priority,
            ) -> Result<Ask, RequestRefused> {
                let mut ask: Option<Ask> = None;
                $(
                    let gate = broker.known(&self.$field.handle)?;
                    let validity = self.$field.validity;
                    ask = Some(match ask {
                        None => Ask::new(priority, gate, validity).held_by(self.$field.holder),
                        Some(ask) => ask.and(gate, validity)?,
                    });
                )+
                ask.ok_or(RequestRefused::UnknownGate)
            }

            fn tickets(
                &self,
                broker: &'b Broker<'g, P, N, G, T, S>,
                seated: &Seated,
            ) -> Option<Self::Tickets> {
                Some(($(broker.ticket(&self.$field.handle, seated.0)?,)+))
            }
        }
    };
}

tuple_of_wants!(D0 P0 0, D1 P1 1);
tuple_of_wants!(D0 P0 0, D1 P1 1, D2 P2 2);
tuple_of_wants!(D0 P0 0, D1 P1 1, D2 P2 2, D3 P3 3);

impl<'g, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Broker<'g, P, N, G, T, S>
{
    /// Requests tickets, all or nothing. They may be waiting when they come:
    /// they become valid in their turn, and refuse with a reason until then.
    ///
    /// # Errors
    /// Only what can never be is refused here.
    ///
    /// # Timing
    /// One step of the books, bounded by the gates and sets. Never blocks.
    pub fn request<'b, W: Wants<'b, 'g, P, N, G, T, S>>(
        &'b self,
        priority: Priority,
        wants: &W,
    ) -> Result<W::Tickets, RequestRefused> {
        let asked = wants.ask(self, priority).and_then(|ask| self.seat(priority, &ask));
        let id = asked.inspect_err(|_| self.record(RecordedEvent::RequestRefused))?;
        self.notify.service_due();
        wants.tickets(self, &Seated(id)).ok_or(RequestRefused::UnknownGate)
    }

    /// Asks for one more gate: what the ticket's grant has is given back, and
    /// all of it asked for, at the old arrival. The ticket stays a ticket of
    /// the grant.
    ///
    /// # Errors
    /// [`RequestRefused`], and everything is as it was.
    ///
    /// # Timing
    /// As [`Broker::request`].
    pub fn extend<'b, D: Device, Q: Platform, E: Device, R: Platform>(
        &'b self,
        ticket: &Ticket<'b, D, Q, Self>,
        want: &Want<'g, E, R>,
    ) -> Result<Ticket<'b, E, R, Self>, RequestRefused> {
        let asked = self.grow(ticket, want);
        let id = asked.inspect_err(|_| self.record(RecordedEvent::RequestRefused))?;
        self.notify.service_due();
        self.ticket(&want.handle, id).ok_or(RequestRefused::UnknownGate)
    }

    fn grow<D: Device, Q: Platform, E: Device, R: Platform>(
        &self,
        ticket: &Ticket<'_, D, Q, Self>,
        want: &Want<'g, E, R>,
    ) -> Result<TicketId, RequestRefused> {
        let gate = self.known(&want.handle)?;
        if !ticket.is_of(self) {
            return Err(RequestRefused::UnknownGate);
        }
        let id = ticket.id();
        let entered = self.enter(|ledger| {
            let now = ledger.clock.now();
            ledger.books.extend(id, gate, want.validity, &mut ledger.actions)?;
            let agents = ledger.books.agents_of(id);
            self.carry_out(ledger, now);
            self.with_standing(id.seat, |standing| standing.set_agents(agents));
            Ok(id)
        });
        entered.unwrap_or(Err(RequestRefused::Unavailable))
    }

    fn seat(&self, priority: Priority, ask: &Ask) -> Result<TicketId, RequestRefused> {
        let entered = self.ledger.with(|ledger| {
            let now = ledger.clock.now();
            ledger.books.step(Event::Tick(now), &mut ledger.actions);
            self.carry_out(ledger, now);
            let id = ledger.books.request(ask, &mut ledger.actions)?;
            let agents = ledger.books.agents_of(id);
            self.with_standing(id.seat, |standing| {
                standing.set_holder(ask.holder());
                standing.seat(id.serial, agents);
            });
            ledger.lane.record(Record::of(now, id, RecordedEvent::Requested { priority }));
            self.carry_out(ledger, now);
            Ok(id)
        });
        entered.unwrap_or(Err(RequestRefused::Unavailable))
    }

    fn record(&self, event: RecordedEvent) {
        self.enter(|ledger| {
            let at = ledger.clock.now();
            ledger.lane.record(Record { at, ticket: 0, event });
        });
    }

    pub(super) fn known<D: Device, Q: Platform>(
        &self,
        handle: &Handle<'g, D, Q>,
    ) -> Result<GateId, RequestRefused> {
        if handle.tag == self.tag { Ok(handle.gate) } else { Err(RequestRefused::UnknownGate) }
    }

    fn ticket<'b, D: Device, Q: Platform>(
        &'b self,
        handle: &Handle<'g, D, Q>,
        id: TicketId,
    ) -> Option<Ticket<'b, D, Q, Self>> {
        let seat = Seat {
            id,
            gate: handle.gate,
            standing: self.standings.get(usize::from(id.seat))?,
            agent: self.agents.get(usize::from(handle.agent))?,
            broker: &self.scope,
        };
        self.key(handle.gate)?.ticket(handle.handle, seat, self)
    }
}
