//! What things are called: priorities and identities.

use core::fmt;

/// How important a request is, from 0 to 255; larger is more important.
///
/// There is no `Ord`: "greater" reads both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Priority(u8);

impl Priority {
    /// The least important.
    pub const LEAST: Self = Self(0);
    /// Ordinary work for the mission.
    pub const SCIENCE: Self = Self(64);
    /// What keeps the spacecraft going.
    pub const ENGINEERING: Self = Self(128);
    /// The first of the levels kept for fault responses.
    pub const FAULT_RESPONSE: Self = Self(240);
    /// Loss of the spacecraft is near.
    pub const EMERGENCY: Self = Self(255);

    /// A priority by its level.
    #[must_use]
    pub const fn new(level: u8) -> Self {
        Self(level)
    }

    /// The level, 0 to 255.
    #[must_use]
    pub const fn level(self) -> u8 {
        self.0
    }

    /// Whether this one goes first.
    #[must_use]
    pub const fn is_more_important_than(self, other: Self) -> bool {
        self.0 > other.0
    }
}

impl fmt::Display for Priority {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "priority {}", self.0)
    }
}

/// A level outside 0 to 255 was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PriorityOutOfRange {
    /// What was asked for.
    pub level: i64,
}

impl fmt::Display for PriorityOutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "priority {} is outside 0 to 255", self.level)
    }
}

impl core::error::Error for PriorityOutOfRange {}

impl TryFrom<i64> for Priority {
    type Error = PriorityOutOfRange;

    fn try_from(level: i64) -> Result<Self, PriorityOutOfRange> {
        u8::try_from(level).map(Self).map_err(|_| PriorityOutOfRange { level })
    }
}

/// A ticket's identity: its seat, and the serial number of the grant that has
/// the seat. An id that outlived its ticket is *stale*: detected, not trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TicketId {
    /// The seat in the broker's table.
    pub seat: u16,
    /// The number of the grant, never used twice by one broker.
    pub serial: usize,
}

impl fmt::Display for TicketId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ticket {}", self.serial)
    }
}

/// A gate's number in its broker, in the order of registration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GateId(pub u8);

impl fmt::Display for GateId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "gate {}", self.0)
    }
}

/// Who holds tickets, by a number of the mission's own: a thread, a subsystem.
/// A supervisor can bar all tickets of a holder together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct HolderId(pub u16);

impl HolderId {
    /// Nobody in particular.
    pub const UNNAMED: Self = Self(0);
}

impl fmt::Display for HolderId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "holder {}", self.0)
    }
}
