//! What a journal gives back after the manager's process has ended.

use crate::manager::Attempt;
use crate::task::{Outcome, Task};
use crate::time::UnixTime;

/// What a journal knows: where a manager goes on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Restored {
    /// The tasks of the schedule, in its order.
    pub tasks: Vec<RestoredTask>,
    /// Modes that were entered and not left.
    pub modes: Vec<String>,
    /// The next position in the schedule.
    pub next_position: u64,
}

/// A task as the journal knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RestoredTask {
    /// The task.
    pub task: Task,
    /// How many tasks of this id were there before.
    pub load: u32,
    /// Its position in the schedule.
    pub position: u64,
    /// When it was accepted.
    pub accepted: UnixTime,
    /// Whether it is held.
    pub held: bool,
    /// Whether the task is over, and kept because others depend on it, or its
    /// id is taken.
    pub over: bool,
    /// The latest outcome, of the occurrence of this number.
    pub ended: Option<(u64, Outcome)>,
    /// How many attempts of the occurrence of this number began, and it is not
    /// over. That is the one after `ended`, or one before it: of those that are
    /// due while it is tried again, the last is missed.
    pub attempts: (u64, u32),
    /// The attempt that began and is not known to be over: it is interrupted.
    pub interrupted: Option<Attempt>,
    /// Whether the occurrence was to start without a sync and may have started:
    /// true only after a power loss.
    pub may_have_started: bool,
    /// Whether a task that it cleans up after has failed or was aborted, and it
    /// has not begun to since.
    pub has_to_clean: bool,
    /// Which of its dependencies were satisfied and not used, in the task's
    /// order. (One on a task that is over is judged by how that ended.)
    pub satisfied: Vec<bool>,
    /// Whether it leaves the schedule when the attempt that began has ended.
    pub leaving: bool,
    /// Whether it runs when another one failed, and never by itself. Such a
    /// task is not over when it ran.
    pub cleans_up: bool,
    /// When the last occurrence that ran was over: its gap counts from then.
    pub ran_until: Option<UnixTime>,
}
