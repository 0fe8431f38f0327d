//! Refusals: outcomes with reasons, not errors of anybody.

use core::fmt;

use crate::fault::GateFault;
use crate::id::Priority;
use crate::standing::Why;
use crate::validity::Denial;

/// Why a command was not issued. The device has not seen it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Refusal {
    /// The ticket is not valid, and may become valid again by itself unless it
    /// is barred or expired.
    NotValid(Why),
    /// All tickets of the agent or the broker were revoked; below the floor
    /// none becomes valid until safe mode is left.
    RevokedAll {
        /// The floor, where safe mode is in force.
        floor: Option<Priority>,
    },
    /// The validity function does not agree.
    Denied(Denial),
    /// The gate is faulted; a supervisor can reset it, unless its owner died.
    Faulted(GateFault),
    /// Somebody else is inside the gate, and the caller did not want to wait.
    Busy,
    /// The calling thread is inside the gate already: a driver must not call
    /// tickets.
    Reentered,
    /// The command declares more draw, flow or time than its device's profile.
    Undeclared,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotValid(why) => write!(f, "the ticket is not valid: {why}"),
            Self::RevokedAll { floor: Some(floor) } => {
                write!(f, "safe mode: nothing below {floor} is valid until it is left")
            }
            Self::RevokedAll { floor: None } => {
                f.write_str("all tickets were revoked; this one is restored in its turn")
            }
            Self::Denied(denial) => write!(f, "the validity function refuses: {denial}"),
            Self::Faulted(fault) => write!(f, "the gate is faulted: {fault}"),
            Self::Busy => f.write_str("the gate is busy; try again, or wait with `invoke`"),
            Self::Reentered => f.write_str("this thread is inside the gate already"),
            Self::Undeclared => f.write_str("the command declares more than its device's profile"),
        }
    }
}

impl core::error::Error for Refusal {}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotYetGranted => f.write_str("not granted yet"),
            Self::Preempted { by, priority } => write!(f, "taken by {by} at {priority}"),
            Self::SupplyFell => f.write_str("the supply fell"),
            Self::Extended => f.write_str("its set is being extended"),
            Self::Resting => f.write_str("its device must rest"),
            Self::GateFaulted => f.write_str("its gate is faulted"),
            Self::RevokedAll => f.write_str("all tickets were revoked"),
            Self::Barred => f.write_str("a supervisor barred it"),
            Self::Expired => f.write_str("it has expired; request a new one"),
            Self::Unknown => f.write_str("several revocations came together"),
        }
    }
}

/// Why an invocation gave no response.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InvokeError<F> {
    /// The command was not issued.
    Refused(Refusal),
    /// The command was issued, and the driver faulted.
    Fault(F),
    /// The command was issued, and the driver panicked.
    Panicked,
}

impl<F> From<Refusal> for InvokeError<F> {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl<F> InvokeError<F> {
    /// The refusal, where the command was not issued.
    #[must_use]
    pub fn refusal(&self) -> Option<Refusal> {
        match self {
            Self::Refused(refusal) => Some(*refusal),
            Self::Fault(_) | Self::Panicked => None,
        }
    }
}

impl<F: fmt::Debug> fmt::Display for InvokeError<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(refusal) => refusal.fmt(f),
            Self::Fault(fault) => write!(f, "issued, and the driver faulted: {fault:?}"),
            Self::Panicked => f.write_str("issued, and the driver panicked"),
        }
    }
}

impl<F: fmt::Debug> core::error::Error for InvokeError<F> {}
