//! What the books know of one grant: a ticket, or a set of them.

use faregate_tickets::id::{GateId, Priority, TicketId};
use faregate_tickets::validity::Validity;

use crate::limits::MAX_SET_GATES;
use crate::refusal::Waiting;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum State {
    /// In line.
    Waiting,
    /// Its gates are being made to admit it.
    Granting,
    /// Valid, unless a supervisor has revoked it since.
    Valid,
    /// Not in line until a supervisor reinstates it.
    Barred,
    /// Not in line until this device is seen off.
    Resting(GateId),
}

/// The agent's record of a ticket, or of a set granted together.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Grant {
    /// 0 while the seat is free.
    pub(crate) serial: usize,
    pub(crate) gates: u64,
    pub(crate) priority: Priority,
    pub(crate) arrival: u64,
    pub(crate) state: State,
    /// Its own epoch, as the books count it: a standing that is ahead of this
    /// was revoked by a supervisor.
    pub(crate) own: usize,
    /// The broker's epoch that was read before it was granted.
    pub(crate) broker_stamp: usize,
    /// It ended the broker's latest epoch itself, and stays below the floor.
    pub(crate) exempt: bool,
    /// For a grant of one gate.
    pub(crate) validity: Validity,
    /// Where a grant of several gates keeps theirs.
    pub(crate) set: Option<u8>,
    pub(crate) blocked: Option<Waiting>,
    pub(crate) next_free: u16,
}

impl Grant {
    pub(crate) fn free(seat: usize) -> Self {
        Self {
            serial: 0,
            gates: 0,
            priority: Priority::LEAST,
            arrival: 0,
            state: State::Waiting,
            // A standing's epoch starts at 1, and is counted on from grant to grant.
            own: 1,
            broker_stamp: 0,
            exempt: false,
            validity: Validity::always(),
            set: None,
            blocked: None,
            next_free: u16::try_from(seat + 1).unwrap_or(u16::MAX),
        }
    }

    /// Whether it stands in line, or has what it stood in line for.
    pub(crate) fn is_eligible(&self) -> bool {
        matches!(self.state, State::Waiting | State::Granting | State::Valid)
    }

    /// Whether it has gates now.
    pub(crate) fn is_granted(&self) -> bool {
        matches!(self.state, State::Granting | State::Valid)
    }

    pub(crate) fn id(&self, seat: u16) -> TicketId {
        TicketId { seat, serial: self.serial }
    }

    /// The place in the total order: the smaller goes first.
    pub(crate) fn rank(&self) -> (u8, u64) {
        (u8::MAX - self.priority.level(), self.arrival)
    }
}

/// The validity functions of a set, one for each of its gates.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct SetBook {
    pub(crate) seat: Option<u16>,
    pub(crate) members: heapless::Vec<(GateId, Validity), MAX_SET_GATES>,
}
