//! What the journal keeps, and the names of what happens.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::task::{Outcome, TaskId};
use crate::time::{Instant, UnixTime};

/// One time that a task is due. `load` tells apart tasks that had the same id
/// one after the other; `number` counts from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Occurrence {
    /// The task.
    pub task: TaskId,
    /// How many tasks of this id were there before.
    pub load: u32,
    /// Which occurrence of the task.
    pub number: u64,
}

/// One try at an occurrence: one process, from its start to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Attempt {
    /// The occurrence.
    pub occurrence: Occurrence,
    /// Which try, from 1.
    pub number: u32,
}

impl fmt::Display for Occurrence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.number == 0 {
            return self.task.fmt(f);
        }
        write!(f, "{} occurrence {}", self.task, self.number)
    }
}

impl fmt::Display for Attempt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} attempt {}", self.occurrence, self.number)
    }
}

/// An entry of the journal, written before what it tells of is acted on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Record {
    /// A task was accepted.
    Accepted {
        /// The task, as it was given.
        task: Box<crate::task::Task>,
        /// How many tasks of this id were there before.
        load: u32,
        /// Its position in the schedule.
        position: u64,
        /// When, by the manager's clock that never jumps.
        at: Instant,
        /// The same by the time of day: what `+N` counts from after a restart.
        wall: UnixTime,
    },
    /// A task was changed (priority or window), or held, or let go on.
    Changed {
        /// The task as it is from now on.
        task: Box<crate::task::Task>,
        /// Whether it is held.
        held: bool,
    },
    /// A task was taken out of the schedule, or has ended for good.
    Removed {
        /// Which task.
        task: TaskId,
        /// How many tasks of this id were there before.
        load: u32,
    },
    /// This occurrence will start when it is due, without a sync: after a power
    /// loss nobody knows whether it did.
    Armed {
        /// Which one.
        occurrence: Occurrence,
    },
    /// It did not start when it was due: it waits.
    Disarmed {
        /// Which one.
        occurrence: Occurrence,
    },
    /// The attempt starts now.
    Starting {
        /// Which one.
        attempt: Attempt,
    },
    /// The attempt was stopped (`true`) or goes on (`false`).
    Paused {
        /// Which one.
        attempt: Attempt,
        /// Whether it was stopped.
        paused: bool,
    },
    /// The attempt is over, which says nothing about the occurrence: one that
    /// was pre-empted is tried again.
    Over {
        /// Which one.
        attempt: Attempt,
        /// What became of it; none: it was pre-empted.
        outcome: Option<Outcome>,
    },
    /// The occurrence is over.
    Ended {
        /// Which one.
        occurrence: Occurrence,
        /// How.
        outcome: Outcome,
        /// When, by the time of day.
        wall: UnixTime,
    },
    /// A mode was entered or left.
    Mode {
        /// Its name.
        name: String,
        /// Whether it was entered.
        entered: bool,
    },
    /// A task runs, and leaves the schedule when it has ended: it does not come
    /// again.
    Leaving {
        /// Which task.
        task: TaskId,
        /// How many tasks of this id were there before.
        load: u32,
    },
    /// A task runs when another one failed, and never by itself.
    CleansUp {
        /// Which task.
        task: TaskId,
        /// How many tasks of this id were there before.
        load: u32,
    },
}
