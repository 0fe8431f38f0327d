//! What a task's process and its command port say to each other.
//!
//! The port is a socket of packets: each is one message. The process inherits
//! it; [`PORT`] names its number.

use serde::{Deserialize, Serialize};

use crate::Refused;
use crate::wire::{Asked, Id, Unreadable};

/// The environment variable with the number of the inherited file descriptor.
pub const PORT: &str = "FAREGATE_PORT";

/// The longest message in bytes.
pub const MAX_MESSAGE: usize = 16 * 1024;

/// What a task's process asks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Ask {
    /// A command, under the task's ticket.
    Command {
        /// The gate.
        gate: String,
        /// The command.
        command: String,
        /// Its arguments.
        #[serde(default)]
        arguments: Vec<String>,
    },
    /// The task is alive.
    Heartbeat,
    /// A connection of its own: the answer carries a file descriptor.
    ///
    /// Who shares the inherited socket with others, as every program that a
    /// script calls does, would else read their answers.
    Open,
    /// [`Notice`]s are to be told on this connection, from now on.
    Notices,
}

/// What a command port says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Said {
    /// An answer: `{"answer": {"id": 7, "what": ...}}`.
    Answer {
        /// To which ask; none: to one that could not be read.
        id: Option<Id>,
        /// What.
        what: Answer,
    },
    /// Something that the task is told unasked.
    Notice(Notice),
}

/// What an ask is answered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// It was done.
    Done {
        /// What the device answered; empty where it says nothing.
        reply: String,
    },
    /// A connection, with this message.
    Opened {
        /// The protocol's version.
        protocol: u32,
    },
    /// It was not done.
    Refused(Refused),
}

/// What the manager tells a task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Notice {
    /// The task goes on after a pause. Its devices were made safe and are not
    /// switched on again: that is the task's own decision.
    Resumed {
        /// The gates whose devices were made safe.
        safed: Vec<String>,
    },
    /// The task is to save its work: it is ended after the grace.
    Checkpoint {
        /// How long it has, in microseconds.
        grace_us: u64,
    },
}

/// Reads what a task's process asks.
///
/// # Errors
/// As [`wire::parse`](crate::wire::parse).
pub fn parse(bytes: &[u8]) -> Result<Asked<Ask>, Unreadable> {
    crate::wire::parse(bytes)
}
