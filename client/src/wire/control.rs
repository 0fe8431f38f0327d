//! What an operator's program and a manager's control port say to each other.
//!
//! Lines of JSON in both directions. The manager begins with [`Said::Hello`].
//! It takes one ask of a connection at a time: the next is read when the one
//! before is answered.

use serde::{Deserialize, Serialize};

use crate::Refused;
use crate::wire::{Asked, Id, Unreadable};

/// The longest line in bytes, its end included: a schedule of 100 000 tasks in
/// one message.
pub const MAX_LINE: usize = 8 * 1024 * 1024;

/// The most tasks that one answer tells of, and that one question can name.
pub const MAX_ROWS: u32 = 1000;

/// What an operator asks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Ask {
    /// Adds the tasks of a schedule, all or none.
    Add {
        /// The file's name: its ending tells the format.
        name: String,
        /// What is in it.
        text: String,
    },
    /// Removes tasks; one that runs is aborted.
    Remove {
        /// Their numbers.
        tasks: Vec<u32>,
    },
    /// Changes a task's priority.
    SetPriority {
        /// Its number.
        task: u32,
        /// From 0 to 239.
        priority: u8,
    },
    /// Changes when a task may start.
    SetWindows {
        /// Its number.
        task: u32,
        /// All of them: the first open one counts.
        windows: Vec<Window>,
    },
    /// Drops what is pending.
    Clear {
        /// Whether what runs ends, too.
        #[serde(default)]
        all: bool,
    },
    /// Keeps a task from starting; one that runs is pre-empted.
    Hold {
        /// Its number.
        task: u32,
    },
    /// Lets a held task go on.
    Resume {
        /// Its number.
        task: u32,
    },
    /// Enters a mode.
    EnterMode {
        /// Its name.
        mode: String,
    },
    /// Leaves a mode.
    LeaveMode {
        /// Its name.
        mode: String,
    },
    /// Where the tasks stand.
    Status(StatusQuery),
    /// [`Said::Note`]s are to be told on this connection, from now on.
    Watch,
    /// Ends everything that runs, in order: the manager is to stop.
    ShutDown,
}

/// Which tasks the status is asked of.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatusQuery {
    /// These, at most [`MAX_ROWS`] of them; empty: all.
    #[serde(default)]
    pub tasks: Vec<u32>,
    /// How many of them are left out, from the first.
    #[serde(default)]
    pub skip: u32,
    /// At most so many, and never more than [`MAX_ROWS`]; none: that many.
    #[serde(default)]
    pub limit: Option<u32>,
}

/// When an attempt may start, both ends inclusive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// The earliest start.
    #[serde(default)]
    pub opens: When,
    /// The latest start.
    #[serde(default)]
    pub closes: When,
}

/// A point in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum When {
    /// No restriction.
    #[default]
    Unrestricted,
    /// So long after this is accepted, in microseconds.
    AfterUs(u64),
    /// At this time of day, in microseconds since 1970.
    UnixUs(i64),
}

/// What a control port says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Said {
    /// The first line.
    Hello {
        /// The protocol's version.
        protocol: u32,
        /// Which program.
        program: String,
    },
    /// An answer: `{"answer": {"id": 7, "what": ...}}`.
    Answer {
        /// To which ask; none: to one without, or that could not be read.
        id: Option<Id>,
        /// What.
        what: Answer,
    },
    /// A change, for who watches.
    Note {
        /// When, by the manager's clock that never jumps, in microseconds.
        at_us: u64,
        /// When, by the time of day, in microseconds since 1970.
        unix_us: i64,
        /// The change, as the schedule manager's `Note` writes it.
        note: serde_json::Value,
    },
    /// So many changes were not told: this connection is read too slowly.
    Lost(u64),
}

/// What an ask is answered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// It was done.
    Done,
    /// Where the tasks stand.
    Status(Status),
    /// It was not done, and nothing changed.
    Refused(Refused),
}

/// Where the tasks stand.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// When this was true, by the manager's clock that never jumps, in
    /// microseconds since its start.
    pub at_us: u64,
    /// The same by the time of day, in microseconds since 1970.
    pub unix_us: i64,
    /// The tasks, in the schedule's order.
    pub tasks: Vec<TaskRow>,
    /// Whether there are more.
    pub more: bool,
}

/// Where a task stands.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TaskRow {
    /// Its number.
    pub task: u32,
    /// What people call it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Which occurrence: the one that lives, or the next.
    pub occurrence: u64,
    /// Its priority.
    pub priority: u8,
    /// Where it stands.
    pub state: State,
    /// Which attempt runs, is being stopped or stands still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attempt: Option<u32>,
    /// When it is due, by the manager's clock, in microseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due_us: Option<u64>,
    /// When it is due, by the time of day, in microseconds since 1970.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due_unix_us: Option<i64>,
    /// What it waits for, and for whom, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waits_for: Option<String>,
}

/// Where an occurrence stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum State {
    /// Its time has not come.
    Pending,
    /// It is due, and waits.
    Waiting,
    /// It runs.
    Running,
    /// It is being stopped.
    Stopping,
    /// It stands still.
    Paused,
    /// It did its work.
    Succeeded,
    /// It ended in a malfunction.
    Failed,
    /// It was ended.
    Aborted,
    /// It never started.
    Missed,
    /// Something that this version of the client does not know.
    #[serde(other)]
    Other,
}

/// Reads what an operator asks: one line, with or without its end.
///
/// # Errors
/// As [`wire::parse`](crate::wire::parse).
pub fn parse(bytes: &[u8]) -> Result<Asked<Ask>, Unreadable> {
    crate::wire::parse(bytes)
}
