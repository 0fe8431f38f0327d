//! What bodies need of others: devices to command, and command ports.

use core::fmt;
use std::io;
use std::os::fd::OwnedFd;

use crate::manager::Attempt;
use crate::time::Duration;

/// Commands devices for a task, on the tickets of its occurrence.
///
/// Called by workers, never by the manager's thread: a device may be slow.
pub trait Commands: Send + Sync {
    /// Issues one command, and gives the device's response.
    ///
    /// # Timing
    /// As long as the device takes.
    ///
    /// # Errors
    /// Why it was not issued, or that the device failed.
    ///
    /// # After revocation
    /// Refused with [`RefusedKind::Taken`] and the name of the taker.
    fn command(
        &self,
        attempt: Attempt,
        gate: &str,
        command: &str,
        arguments: &[String],
    ) -> Result<String, CommandRefused>;

    /// The longest time that the command may take, where it is declared.
    fn wcet(&self, gate: &str, command: &str) -> Option<Duration> {
        let _ = (gate, command);
        None
    }
}

/// A command that was not done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandRefused {
    /// What kind of refusal, for programs.
    pub kind: RefusedKind,
    /// Which rule, by how much, who has it, for people.
    pub reason: String,
    /// Who took the tickets, where that is known: a task, a mode.
    pub taken_by: Option<String>,
}

impl CommandRefused {
    /// A refusal of this kind, for this reason, of which no taker is known.
    #[must_use]
    pub fn new(kind: RefusedKind, reason: impl Into<String>) -> Self {
        Self { kind, reason: reason.into(), taken_by: None }
    }
}

/// The kinds of refusals of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RefusedKind {
    /// The tickets of the task were taken. They may become valid again.
    Taken,
    /// The attempt is over, or was never known.
    Over,
    /// The mission has no gate of this name.
    NoSuchGate,
    /// The task did not say that it would command this gate.
    NotItsGate,
    /// The gate has no such command, or not with these arguments.
    BadCommand,
    /// A validity function disagrees.
    NotNow,
    /// The device failed, or its gate is faulted.
    Fault,
}

impl fmt::Display for CommandRefused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl core::error::Error for CommandRefused {}

/// Gives each attempt's process its way to the manager, and ends it.
///
/// Called by the manager's thread; returns at once.
pub trait PortFactory: Send {
    /// A port for this attempt: the end that its process inherits. `None`: it
    /// has none.
    ///
    /// # Errors
    /// When the host gives no socket. The body is then not started.
    fn open(&mut self, attempt: Attempt) -> io::Result<Option<OwnedFd>>;

    /// Tells the process something. What cannot be told is lost: a process need
    /// not listen.
    fn tell(&mut self, attempt: Attempt, notice: PortNotice);

    /// The attempt is over: from now on nothing that comes through its port
    /// has an effect, whoever has the other end. No command begins any more;
    /// one may be in progress.
    fn close(&mut self, attempt: Attempt);

    /// Whether no command of the attempt is in progress. The end of an attempt
    /// is told when this is so after [`close`](Self::close): the next attempt
    /// has the same tickets, and a command that began for this one must not be
    /// issued under them. The manager's thread is woken when it becomes so.
    fn is_quiet(&self, attempt: Attempt) -> bool {
        let _ = attempt;
        true
    }
}

/// What a process is told through its port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PortNotice {
    /// It is to save its work and end within this time.
    Checkpoint {
        /// How long it has.
        grace: Duration,
    },
    /// It stood still, and goes on: its devices were made safe meanwhile.
    Resumed,
}

/// No ports: for schedules whose processes command nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPorts;

impl PortFactory for NoPorts {
    fn open(&mut self, _: Attempt) -> io::Result<Option<OwnedFd>> {
        Ok(None)
    }

    fn tell(&mut self, _: Attempt, _: PortNotice) {}

    fn close(&mut self, _: Attempt) {}
}

/// No devices: every command is refused.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoDevices;

impl Commands for NoDevices {
    fn command(
        &self,
        _: Attempt,
        gate: &str,
        _: &str,
        _: &[String],
    ) -> Result<String, CommandRefused> {
        let reason = format!("the mission has no gate {gate:?}");
        Err(CommandRefused::new(RefusedKind::NoSuchGate, reason))
    }
}
