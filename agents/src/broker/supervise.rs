//! Supervisors: who may revoke what is not theirs.

use core::fmt;

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Clock;
use faregate_tickets::device::Device;
use faregate_tickets::gate::{Blocked, Key};
use faregate_tickets::id::{GateId, HolderId, Priority, TicketId};
use faregate_tickets::notify::Notify;
use faregate_tickets::platform::Platform;
use faregate_tickets::recorder::{Lane, Record, RecordedEvent};
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::Standing;
use faregate_tickets::ticket::Ticket;

use crate::books::Event;

use super::{AgentId, Broker};

/// The authority to revoke: of a whole broker, or of one agent.
///
/// Made while the broker is put together; nobody without one can revoke what
/// is not theirs.
#[derive(Debug)]
pub struct Supervisor {
    tag: usize,
    agent: Option<u8>,
}

/// Why a supervisor's order was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NotYours {
    /// The supervisor is another broker's, or another agent's.
    OtherScope,
    /// The ticket has ended; nobody was revoked.
    Stale,
    /// The broker's books cannot be entered: a thread died inside, or this one
    /// is inside.
    Unavailable,
}

impl fmt::Display for NotYours {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OtherScope => "the supervisor has no authority there",
            Self::Stale => "the ticket has ended already",
            Self::Unavailable => "the broker's books cannot be entered",
        })
    }
}

impl core::error::Error for NotYours {}

/// Something was revoked. A command that was admitted before it may still be in
/// progress, until [`quiesce`](Revoked::quiesce) has returned.
#[must_use = "a command admitted before may still be in progress: `quiesce` waits for it"]
pub struct Revoked<'b> {
    keys: &'b [Key<'b>],
    /// The agent of each gate.
    agents_of_gates: &'b [u8],
    /// The agents concerned, one bit each.
    agents: usize,
}

/// No command of what was revoked is in progress, and everything it did is
/// visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quiescent(());

/// A gate could not be passed: a command may still be in progress there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NotQuiescent {
    /// Which gate.
    pub gate: GateId,
    /// Why.
    pub blocked: Blocked,
}

impl fmt::Display for NotQuiescent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let why = match self.blocked {
            Blocked::Hung => "its command in progress did not come back in time",
            Blocked::Reentered => "the calling thread is inside one of its commands",
            Blocked::Stale => "it has moved on",
        };
        write!(f, "{}: {why}", self.gate)
    }
}

impl core::error::Error for NotQuiescent {}

impl Revoked<'_> {
    /// Passes once through each gate of the agents concerned.
    ///
    /// # Errors
    /// The first gate whose command in progress did not come back in time; it
    /// is faulted.
    ///
    /// # Timing
    /// One command in progress for each gate, with priority inheritance where
    /// the gate's strategy has it.
    pub fn quiesce(self) -> Result<Quiescent, NotQuiescent> {
        for ((number, key), agent) in (0..).zip(self.keys).zip(self.agents_of_gates) {
            if self.agents & (1 << agent) == 0 {
                continue;
            }
            let patience = key.profile().patience();
            key.pass(patience).map_err(|blocked| NotQuiescent { gate: GateId(number), blocked })?;
        }
        Ok(Quiescent(()))
    }

    /// Leaves it to the broker's service to reach quiescence.
    pub fn without_waiting(self) {}
}

impl fmt::Debug for Revoked<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Revoked")
    }
}

impl<'g, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Broker<'g, P, N, G, T, S>
{
    /// Makes a supervisor of the whole broker.
    pub fn supervisor(&mut self) -> Supervisor {
        Supervisor { tag: self.tag, agent: None }
    }

    /// Makes a supervisor of one agent.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`] for another broker's agent.
    pub fn supervisor_of(&mut self, agent: AgentId) -> Result<Supervisor, NotYours> {
        if agent.tag != self.tag {
            return Err(NotYours::OtherScope);
        }
        Ok(Supervisor { tag: self.tag, agent: Some(agent.number) })
    }

    /// Bars a ticket, or the set it was granted with: not valid from now, and
    /// not in line until it is reinstated. Its devices are made safe.
    ///
    /// # Errors
    /// [`NotYours`].
    ///
    /// # Timing
    /// Constant: three atomic writes, which nobody can delay; after them the
    /// service is woken.
    pub fn bar(&self, supervisor: &Supervisor, ticket: TicketId) -> Result<Revoked<'_>, NotYours> {
        let standing = self.standing_of(supervisor, ticket)?;
        #[cfg(feature = "mutant-noted-early")]
        self.scope.note_bar(ticket.seat);
        standing.bar(ticket.serial);
        #[cfg(not(feature = "mutant-noted-early"))]
        self.scope.note_bar(ticket.seat);
        self.notify.service_due();
        // Its grant may be getting gates of other agents at this moment.
        Ok(self.revoked(usize::MAX))
    }

    /// Bars every ticket that this holder has; see [`Broker::bar`]. Each is
    /// reinstated by itself.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`]: it takes a supervisor of the whole broker.
    ///
    /// # Timing
    /// One look at each seat, and as [`Broker::bar`] for each ticket found;
    /// nobody can delay it.
    pub fn bar_holder(
        &self,
        supervisor: &Supervisor,
        holder: HolderId,
    ) -> Result<Revoked<'_>, NotYours> {
        self.scope_of(supervisor)?;
        if supervisor.agent.is_some() {
            return Err(NotYours::OtherScope);
        }
        for (seat, standing) in (0..).zip(&self.standings) {
            if let Some(serial) = standing.occupant_of(holder) {
                standing.bar(serial);
                self.scope.note_bar(seat);
            }
        }
        self.notify.service_due();
        Ok(self.revoked(usize::MAX))
    }

    /// Puts a barred ticket back in line, behind those who came meanwhile.
    ///
    /// # Errors
    /// [`NotYours`].
    ///
    /// # Timing
    /// One call of [`Broker::service`], which may wait at gates, and one step.
    pub fn reinstate(&self, supervisor: &Supervisor, ticket: TicketId) -> Result<(), NotYours> {
        let standing = self.standing_of(supervisor, ticket)?;
        // The bar itself may not have been noticed yet.
        self.service();
        if standing.is_occupied_by(ticket.serial) {
            standing.forget_bar();
        }
        self.order(RecordedEvent::Reinstated, ticket.serial);
        self.tell(Event::Reinstated(ticket)).ok_or(NotYours::Unavailable)
    }

    /// Enters safe mode: everything in the supervisor's scope is pre-empted,
    /// its devices are made safe, and nothing below the floor becomes valid
    /// until safe mode is left.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`].
    ///
    /// # Timing
    /// Constant: one atomic store and one atomic increment, which nobody can
    /// delay; after them the service is woken. Making the devices safe takes it
    /// its time.
    pub fn enter_safe_mode(
        &self,
        supervisor: &Supervisor,
        floor: Priority,
    ) -> Result<Revoked<'_>, NotYours> {
        self.scope_of(supervisor)?.enter_safe_mode(floor);
        self.notify.service_due();
        Ok(self.revoked(supervisor.agent.map_or(usize::MAX, |agent| 1 << agent)))
    }

    /// Leaves safe mode: tickets are restored in their order.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`].
    ///
    /// # Timing
    /// One atomic store, and one entry into the books for the record.
    pub fn leave_safe_mode(&self, supervisor: &Supervisor) -> Result<(), NotYours> {
        self.scope_of(supervisor)?.leave_safe_mode();
        self.order(RecordedEvent::SafeModeLeft, 0);
        self.notify.service_due();
        Ok(())
    }

    /// Enters safe mode, except for one ticket, which its holder brings. That
    /// one is exempt only if it was still valid; the answer says so.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`]: it takes a supervisor of the whole broker, and
    /// a ticket of it. Nothing is revoked then.
    ///
    /// # Timing
    /// Constant, as [`Broker::enter_safe_mode`].
    pub fn revoke_all_but_me<D: Device, Q: Platform>(
        &self,
        supervisor: &Supervisor,
        ticket: &Ticket<'_, D, Q, Self>,
        floor: Priority,
    ) -> Result<(bool, Revoked<'_>), NotYours> {
        if supervisor.agent.is_some() || !ticket.is_of(self) {
            return Err(NotYours::OtherScope);
        }
        let scope = self.scope_of(supervisor)?;
        let exempt = ticket.revoke_all_but_me(scope, floor);
        self.notify.service_due();
        Ok((exempt, self.revoked(usize::MAX)))
    }

    /// The agent's supply is this from now on. One that falls takes victims at
    /// once, which is why it takes a supervisor to say so.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`].
    ///
    /// # Timing
    /// One step of the books; what follows from it is for the next service.
    pub fn set_supply(
        &self,
        supervisor: &Supervisor,
        agent: AgentId,
        supply: Milliwatts,
    ) -> Result<(), NotYours> {
        self.scope_of(supervisor)?;
        let theirs = supervisor.agent.is_none_or(|number| number == agent.number);
        if agent.tag != self.tag || !theirs {
            return Err(NotYours::OtherScope);
        }
        self.order(RecordedEvent::Supply { supply }, 0);
        let told = self.tell(Event::Supply { agent: agent.number, supply });
        told.ok_or(NotYours::Unavailable)
    }

    /// Takes a faulted gate back into use: its driver may be called again, and
    /// its device is orphaned.
    /// A gate whose owner died stays faulted.
    ///
    /// # Errors
    /// [`NotYours::OtherScope`].
    ///
    /// # Timing
    /// One step of the books.
    pub fn reset_gate(&self, supervisor: &Supervisor, gate: GateId) -> Result<(), NotYours> {
        self.scope_of(supervisor)?;
        let agent = self.enter(|ledger| ledger.books.agent_of(gate)).flatten();
        if supervisor.agent.is_some_and(|own| Some(own) != agent) {
            return Err(NotYours::OtherScope);
        }
        self.key(gate).ok_or(NotYours::OtherScope)?.reopen();
        self.order(RecordedEvent::Reopened, 0);
        self.tell(Event::Reset(gate)).ok_or(NotYours::Unavailable)
    }

    /// The standing of a ticket that the supervisor may bar and reinstate.
    fn standing_of(
        &self,
        supervisor: &Supervisor,
        ticket: TicketId,
    ) -> Result<&Standing, NotYours> {
        self.scope_of(supervisor)?;
        let standing = self.standings.get(usize::from(ticket.seat)).ok_or(NotYours::Stale)?;
        if !standing.is_occupied_by(ticket.serial) {
            return Err(NotYours::Stale);
        }
        if supervisor.agent.is_some_and(|agent| standing.agents() & (1 << agent) == 0) {
            return Err(NotYours::OtherScope);
        }
        Ok(standing)
    }

    fn revoked(&self, agents: usize) -> Revoked<'_> {
        Revoked { keys: &self.keys, agents_of_gates: &self.agents_of_gates, agents }
    }

    fn scope_of(&self, supervisor: &Supervisor) -> Result<&Scope, NotYours> {
        if supervisor.tag != self.tag {
            return Err(NotYours::OtherScope);
        }
        match supervisor.agent {
            None => Ok(&self.scope),
            Some(agent) => self.agents.get(usize::from(agent)).ok_or(NotYours::OtherScope),
        }
    }

    fn order(&self, event: RecordedEvent, ticket: usize) {
        self.enter(|ledger| {
            let at = ledger.clock.now();
            ledger.lane.record(Record { at, ticket, event });
        });
    }
}
