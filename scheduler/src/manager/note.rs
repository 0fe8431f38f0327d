//! What the manager tells people, one line for each change.

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;
use serde::{Deserialize, Serialize};

use crate::manager::{Attempt, Exit, Occurrence};
use crate::task::{Outcome, TaskId};
use crate::time::Duration;

/// A change, for displays, telemetry and traces. A trace of notes with their
/// instants is what two executives of one schedule are compared by.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Note {
    /// A task came into the schedule.
    Accepted(TaskId),
    /// A task left the schedule before its time.
    Removed(TaskId),
    /// An occurrence waits, and for what. Told of the most important ones; the
    /// others are told of when they are asked for.
    Waits {
        /// Which one.
        occurrence: Occurrence,
        /// For what.
        waits_for: WaitsFor,
    },
    /// An attempt started.
    Started(Attempt),
    /// An attempt is being stopped, for whom.
    Stopping {
        /// Which one.
        attempt: Attempt,
        /// For whom or why, for people.
        why: String,
    },
    /// A body stands still.
    Paused(Attempt),
    /// A body goes on.
    Resumed(Attempt),
    /// An attempt is over, and will be run again: it was pre-empted.
    Preempted(Attempt),
    /// An attempt is over.
    Over {
        /// Which one.
        attempt: Attempt,
        /// How the body ended.
        exit: Exit,
        /// What that means.
        outcome: Outcome,
    },
    /// The occurrence is over: succeeded, failed or aborted.
    Ended {
        /// Which one.
        occurrence: Occurrence,
        /// How.
        outcome: Outcome,
    },
    /// Occurrences that never ran, told once for each run of misses.
    Missed {
        /// The task.
        task: TaskId,
        /// The first and the last of them.
        first: u64,
        /// The last of them.
        last: u64,
        /// How many.
        count: u64,
        /// Why.
        why: String,
    },
    /// A task can never run, at once or from now on.
    NeverRuns {
        /// The task.
        task: TaskId,
        /// Why.
        why: String,
    },
    /// An attempt runs longer than its duration.
    Overran {
        /// Which one.
        attempt: Attempt,
        /// Its duration.
        duration: Duration,
    },
    /// A function did not return after its grace; its worker is lost.
    Runaway(Attempt),
    /// A mode was entered (`true`) or left.
    Mode {
        /// Its name.
        name: String,
        /// Whether it was entered.
        entered: bool,
    },
}

/// What an occurrence that is due waits for.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum WaitsFor {
    /// Its window has not opened, or its back-off is not over.
    Time,
    /// Another task's outcome.
    Dependency(TaskId),
    /// Categories.
    Categories {
        /// Which ones.
        shared: Categories,
        /// Who has them.
        by: HeldBy,
    },
    /// A gate.
    Gate {
        /// Its name.
        gate: String,
        /// Who has it.
        by: HeldBy,
    },
    /// Draw.
    Draw {
        /// How much is missing.
        short_by: Milliwatts,
    },
    /// Memory.
    Memory {
        /// How many bytes are missing.
        short_by: u64,
    },
    /// Storage.
    Storage {
        /// How many bytes are missing.
        short_by: u64,
    },
    /// The battery's state of charge.
    Battery {
        /// What it is; none: no estimate.
        now: Option<u8>,
        /// What is wanted.
        wanted: u8,
    },
    /// A place among the tasks that run.
    Slot,
    /// A mode to be left.
    Mode(String),
    /// A telecommand that lets it go on.
    Held,
    /// Cannot be pre-empted, and would keep a more important one waiting.
    MoreImportant(TaskId),
    /// The agents: what they say.
    Tickets(String),
    /// Its tickets are being handed over.
    HandOver,
}

/// Who holds what another one waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum HeldBy {
    /// A task.
    Task(TaskId),
    /// A task that ended, and whose gap is not over.
    GapOf(TaskId),
    /// Nobody that is known.
    Unknown,
}
