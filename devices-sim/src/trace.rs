//! What reached the devices.

use std::borrow::Cow;
use std::fmt;

use faregate_tickets::clock::Instant;

use crate::device::Command;

/// A command that a driver received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReceivedCommand {
    /// When the driver was called.
    pub begun: Instant,
    /// When the command reached the device, or was seen to fail.
    pub done: Option<Instant>,
    /// Which.
    pub command: Command,
    /// Whether the driver was asked to make its device safe.
    pub safing: bool,
    /// The body of the interleaver, or the thread, that called.
    pub by: Cow<'static, str>,
    /// What became of it.
    pub outcome: Outcome,
}

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// It is under way, or its caller was lost with it.
    InProgress,
    /// The device did it.
    Took,
    /// The device got it, and nothing changed: it was so already, or a fault
    /// made it ignore the command.
    NoEffect,
    /// The driver failed, and the device did not get it.
    DriverFailed,
    /// The spacecraft was lost before.
    TooLate,
}

impl fmt::Display for ReceivedCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let safing = if self.safing { " (safing)" } else { "" };
        write!(f, "{} {}: {:?}{safing} -> {:?}", self.begun, self.by, self.command, self.outcome)?;
        self.done.map_or(Ok(()), |done| write!(f, " at {done}"))
    }
}
