//! The recorder port: what happened, for the flight recorder.

use core::cell::Cell;

use crate::amount::Milliwatts;
use crate::clock::Instant;
use crate::fault::GateFault;
use crate::id::{GateId, Priority, TicketId};
use crate::standing::Why;

/// One lane of the flight recorder. Each gate and each broker writes its own,
/// under its own lock, so a lane has one writer at a time.
///
/// # Timing
/// Runs inside the critical section: put the record into a bounded queue, and
/// when that is full count the loss instead of waiting.
pub trait Lane: Send {
    /// Keeps the record, or counts that it could not be kept.
    fn record(&mut self, record: Record);
}

/// A lane that keeps nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoLane;

impl Lane for NoLane {
    fn record(&mut self, _: Record) {}
}

/// What happened, to whom, when. Which gate or broker it was is the lane's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Record {
    /// When, by the clock of the gate or broker that writes.
    pub at: Instant,
    /// The serial of the ticket concerned; 0 where none is.
    pub ticket: usize,
    /// What happened.
    pub event: RecordedEvent,
}

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RecordedEvent {
    /// A command was issued.
    Issued {
        /// The command's number.
        code: u16,
    },
    /// Commands that are one store were issued since the ticket's last record.
    Stored {
        /// How many.
        count: u32,
    },
    /// Commands were refused since the ticket's last record.
    Refused {
        /// How many.
        count: u32,
    },
    /// The gate admits the ticket.
    Admitted {
        /// The number of this change of tenant.
        tenure: usize,
    },
    /// The gate admits nobody.
    Vacated {
        /// The number of this change of tenant.
        tenure: usize,
    },
    /// The safing command was issued.
    Safed {
        /// Which attempt it was, from 1.
        attempt: u8,
    },
    /// The gate became faulted.
    Closed(GateFault),
    /// A supervisor reset the gate.
    Reopened,
    /// The clock went backwards; time stands still until it is back.
    ClockWentBack,
    /// A ticket was requested.
    Requested {
        /// At this priority.
        priority: Priority,
    },
    /// A request was refused.
    RequestRefused,
    /// The ticket became valid.
    Granted,
    /// The ticket was revoked.
    Revoked(Why),
    /// The ticket was given back.
    Relinquished,
    /// The ticket's grant is over.
    Ended,
    /// A barred ticket was reinstated.
    Reinstated,
    /// The device was freshly seen off.
    SeenOff {
        /// Its gate.
        gate: GateId,
    },
    /// The device could not be made safe.
    Stuck {
        /// Its gate.
        gate: GateId,
    },
    /// The gate became faulted, as its agent noticed.
    Faulted {
        /// Which gate.
        gate: GateId,
        /// Why.
        fault: GateFault,
    },
    /// The supply changed.
    Supply {
        /// To this much.
        supply: Milliwatts,
    },
    /// Safe mode was entered, with this floor.
    SafeMode {
        /// Nothing below it becomes valid.
        floor: Priority,
    },
    /// Safe mode was left.
    SafeModeLeft,
}

/// What a ticket has counted since its last record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Unrecorded {
    /// Commands that were refused.
    pub refused: u32,
    /// Commands that were one store, and issued.
    pub stored: u32,
}

impl Unrecorded {
    /// Whether nothing was counted.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.refused == 0 && self.stored == 0
    }

    /// The records of it that there are. An array, because two iterators in a
    /// chain become a loop.
    #[must_use]
    pub fn events(self) -> [Option<RecordedEvent>; 2] {
        let stored = (self.stored > 0).then_some(RecordedEvent::Stored { count: self.stored });
        let refused = (self.refused > 0).then_some(RecordedEvent::Refused { count: self.refused });
        [stored, refused]
    }
}

/// A ticket's counts. Each is a cell of its own: what is written as two words
/// and read back as one at the next command is waited for.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    refused: Cell<u32>,
    stored: Cell<u32>,
}

impl Counts {
    /// One more command was refused. More than can be counted are as many.
    pub(crate) fn refuse(&self) {
        self.refused.set(self.refused.get().saturating_add(1));
    }

    /// One more command was one store, and issued; answers how many.
    #[inline]
    pub(crate) fn store(&self) -> u32 {
        let stored = self.stored.get().saturating_add(1);
        self.stored.set(stored);
        stored
    }

    #[cfg(test)]
    pub(crate) fn with_stores(stored: u32) -> Self {
        Self { refused: Cell::new(0), stored: Cell::new(stored) }
    }

    pub(crate) fn get(&self) -> Unrecorded {
        Unrecorded { refused: self.refused.get(), stored: self.stored.get() }
    }

    /// What was counted; it is counted anew from here on.
    pub(crate) fn take(&self) -> Unrecorded {
        Unrecorded { refused: self.refused.take(), stored: self.stored.take() }
    }
}

impl Record {
    /// A record about a ticket.
    #[must_use]
    pub const fn of(at: Instant, ticket: TicketId, event: RecordedEvent) -> Self {
        Self { at, ticket: ticket.serial, event }
    }
}
