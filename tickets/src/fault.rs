//! Faulted gates: closed to tickets, open to the agent's safing.

use core::fmt;

/// Why a gate is faulted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GateFault {
    /// The driver answered a command or a safing with a fault.
    Driver,
    /// The driver panicked.
    Panicked,
    /// A command took longer than its declared time by the declared factor.
    Overran,
    /// A command had not come back when quiescence was due.
    Hung,
    /// A thread died inside a command, without unwinding. What it left behind
    /// the lock may be torn, so this one is for good: it cannot be reset.
    OwnerDied,
}

impl GateFault {
    pub(crate) const fn code(fault: Option<Self>) -> usize {
        match fault {
            None => 0,
            Some(Self::Driver) => 1,
            Some(Self::Panicked) => 2,
            Some(Self::Overran) => 3,
            Some(Self::Hung) => 4,
            Some(Self::OwnerDied) => 5,
        }
    }

    pub(crate) const fn from_code(code: usize) -> Option<Self> {
        match code {
            1 => Some(Self::Driver),
            2 => Some(Self::Panicked),
            3 => Some(Self::Overran),
            4 => Some(Self::Hung),
            5 => Some(Self::OwnerDied),
            _ => None,
        }
    }
}

impl fmt::Display for GateFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Driver => "its driver reported a fault",
            Self::Panicked => "its driver panicked",
            Self::Overran => "a command overran its declared time",
            Self::Hung => "a command did not come back",
            Self::OwnerDied => "a thread died inside a command",
        })
    }
}
