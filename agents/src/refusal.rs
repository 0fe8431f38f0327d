//! Why a request is refused, and why one waits.

use core::fmt;

use faregate_tickets::amount::{Microjoules, Milligrams, Milliwatts};
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::{GateId, Priority, TicketId};

use crate::policy::Categories;

/// Why a request can never be fulfilled. Everything else waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RequestRefused {
    /// The gate is not registered with this broker.
    UnknownGate,
    /// The request names no gate.
    NoGate,
    /// The request names a gate twice, or one that the ticket has already.
    GateTwice(GateId),
    /// More draw than the agent's supply has ever been.
    OverSupply {
        /// What the request would draw, largest draws summed.
        draw: Milliwatts,
        /// The largest supply.
        supply: Milliwatts,
    },
    /// The energy budget asked for is not left.
    NoEnergy {
        /// What was asked for.
        asked: Microjoules,
        /// What is left.
        left: Microjoules,
    },
    /// The propellant budget asked for is not left.
    NoPropellant {
        /// What was asked for.
        asked: Milligrams,
        /// What is left.
        left: Milligrams,
    },
    /// A table is full.
    NoCapacity(Capacity),
    /// The ticket to be extended is stale or expired.
    Stale,
    /// The broker's lock cannot be entered (a thread died inside, or this one
    /// is inside), or the broker was closed.
    Unavailable,
}

/// Which table is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Capacity {
    /// The seats for tickets.
    Seats,
    /// The table of all-or-nothing requests.
    Sets,
    /// The gates in one all-or-nothing request.
    SetGates,
    /// The validity functions of one ticket (a lease takes one).
    ValidityFunctions,
}

impl fmt::Display for RequestRefused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownGate => f.write_str("the gate is not registered with this broker"),
            Self::NoGate => f.write_str("the request names no gate"),
            Self::GateTwice(gate) => write!(f, "the request names {gate} twice"),
            Self::OverSupply { draw, supply } => {
                write!(f, "it would draw {draw}, and the supply is {supply} at most")
            }
            Self::NoEnergy { asked, left } => {
                write!(f, "it asks for {asked} of energy, and {left} is left")
            }
            Self::NoPropellant { asked, left } => {
                write!(f, "it asks for {asked} of propellant, and {left} is left")
            }
            Self::NoCapacity(Capacity::Seats) => {
                f.write_str("no seat is free; build the broker with more")
            }
            Self::NoCapacity(Capacity::Sets) => {
                f.write_str("no set is free; build the broker with more")
            }
            Self::NoCapacity(Capacity::SetGates) => f.write_str("too many gates in one request"),
            Self::NoCapacity(Capacity::ValidityFunctions) => {
                f.write_str("too many validity functions, the lease included")
            }
            Self::Stale => f.write_str("the ticket has expired; request a new one"),
            Self::Unavailable => {
                f.write_str("the broker's books cannot be entered, or it was closed")
            }
        }
    }
}

impl core::error::Error for RequestRefused {}

/// Why a device was not declared anew. Everything is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NotRedeclared {
    /// The gate is not registered with this broker.
    UnknownGate,
    /// A ticket names the gate, valid or not.
    Requested {
        /// Which one.
        by: TicketId,
    },
    /// The device may be on: it has not been seen off since it was last used.
    MayBeOn,
    /// The broker's books cannot be entered: a thread died inside, or this one
    /// is inside.
    Unavailable,
}

impl fmt::Display for NotRedeclared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownGate => f.write_str("the gate is not registered with this broker"),
            Self::Requested { by } => write!(f, "{by} names the gate; relinquish it first"),
            Self::MayBeOn => f.write_str("the device may be on; it must be seen off first"),
            Self::Unavailable => f.write_str("the broker's books cannot be entered"),
        }
    }
}

impl core::error::Error for NotRedeclared {}

/// What a waiting ticket waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Waiting {
    /// A more important ticket has, or is next in line for, this gate.
    Gate {
        /// Which gate.
        gate: GateId,
        /// Who has it or is next.
        by: TicketId,
    },
    /// The margin left by more important tickets and stuck devices is too
    /// small.
    Margin {
        /// By how much.
        short_by: Milliwatts,
    },
    /// Conflict categories are used by a more important ticket, or by a device
    /// that is stuck.
    Categories {
        /// Which ones.
        shared: Categories,
        /// By whom, where it is a ticket.
        by: Option<TicketId>,
    },
    /// The agent allows one ticket at a time.
    Exclusive {
        /// Who has it.
        by: TicketId,
    },
    /// The gate is faulted; a supervisor can reset it, unless its owner died.
    Faulted {
        /// Which gate.
        gate: GateId,
        /// Why.
        fault: GateFault,
    },
    /// Safe mode: nothing below the floor becomes valid.
    SafeMode {
        /// The floor.
        floor: Priority,
    },
    /// A supervisor barred the ticket.
    Barred,
    /// The device must be seen off first.
    Resting,
    /// It is next: a gate is being vacated, or a device made safe.
    HandOver,
}

impl fmt::Display for Waiting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gate { gate, by } => write!(f, "{gate} is taken by {by}"),
            Self::Margin { short_by } => write!(f, "the margin is short by {short_by}"),
            Self::Categories { shared, by: Some(by) } => {
                write!(f, "conflict categories {shared} are used by {by}")
            }
            Self::Categories { shared, by: None } => {
                write!(f, "conflict categories {shared} are held by a stuck device")
            }
            Self::Exclusive { by } => write!(f, "its agent allows one ticket at a time: {by}"),
            Self::Faulted { gate, fault } => write!(f, "{gate} is faulted: {fault}"),
            Self::SafeMode { floor } => write!(f, "safe mode: nothing below {floor}"),
            Self::Barred => f.write_str("a supervisor barred it"),
            Self::Resting => f.write_str("its device must be seen off first"),
            Self::HandOver => f.write_str("its hand-over is under way"),
        }
    }
}
