//! What can happen to the manager.

use serde::{Deserialize, Serialize};

use crate::manager::{Attempt, Occurrence};
use crate::task::{Task, TaskId, TaskPriority, Window};

/// Something that happened, or that somebody asks for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// A body is over, whatever was asked of it. Of what happens at one
    /// instant, this comes first.
    Exited {
        /// Which attempt.
        attempt: Attempt,
        /// How.
        exit: Exit,
    },
    /// A body stands still, as [`Action::Stop`](crate::manager::Action::Stop)
    /// asked: its processes are stopped. (One that was to be checkpointed or
    /// killed exits instead.)
    Stopped {
        /// Which attempt.
        attempt: Attempt,
    },
    /// The grace of a function is over, and it has not returned.
    Runaway {
        /// Which attempt.
        attempt: Attempt,
    },
    /// The body says that it is alive.
    Heartbeat {
        /// Which attempt.
        attempt: Attempt,
    },
    /// All tickets of the occurrence are valid.
    Granted {
        /// Which one.
        occurrence: Occurrence,
    },
    /// The tickets of the occurrence were taken: its commands have no effect
    /// from now on.
    Taken {
        /// Whose tickets.
        occurrence: Occurrence,
        /// Who took them, or why they went, for people.
        by: String,
    },
    /// The tickets that were asked for wait, for something that is not in the
    /// manager's own hands.
    Blocked {
        /// Which one.
        occurrence: Occurrence,
        /// For what and for whom, for people.
        why: String,
    },
    /// The tickets that were asked for can never be had.
    Refused {
        /// Which one.
        occurrence: Occurrence,
        /// Why.
        why: String,
    },
    /// Something was measured.
    Reading(Reading),
    /// Somebody commands the manager.
    Telecommand {
        /// To answer by.
        id: TelecommandId,
        /// What is asked.
        telecommand: Telecommand,
    },
}

/// How a body ended.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Exit {
    /// A process ended with this exit code, or a function returned: 0 is
    /// success.
    Code(i32),
    /// A process was ended by this signal.
    Signal(i32),
    /// A function panicked.
    Panicked(String),
    /// A sequence ended because a command was refused, or a function said that
    /// it failed.
    Failed(String),
    /// The body could not be started.
    NotStarted(String),
}

/// Something that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Reading {
    /// The battery's state of charge, in percent; none: no estimate any more.
    Battery(Option<u8>),
    /// Bytes of memory available to tasks.
    Memory(u64),
    /// Bytes of storage available to tasks.
    Storage(u64),
    /// Bytes of memory that a running attempt uses.
    Used {
        /// Which attempt.
        attempt: Attempt,
        /// How many bytes.
        memory: u64,
    },
}

/// Tells telecommands apart, so that each has its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TelecommandId(pub u64);

/// A task that is to come into the schedule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Addition {
    /// The task.
    pub task: Task,
}

/// What can be asked of a running manager.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Telecommand {
    /// Adds these tasks, all or none, in this order. A load of a file is one
    /// event.
    Add(Vec<Addition>),
    /// Removes tasks; one that runs is aborted.
    Remove(Vec<TaskId>),
    /// Changes a task's priority.
    SetPriority(TaskId, TaskPriority),
    /// Changes a task's windows.
    SetWindows(TaskId, Vec<Window>),
    /// Drops what is pending; with `all` ends what runs, too.
    Clear {
        /// Whether what runs ends, too.
        all: bool,
    },
    /// Keeps a task from starting; one that runs is pre-empted.
    Hold(TaskId),
    /// Lets a held task go on.
    Resume(TaskId),
    /// Enters a mode.
    EnterMode(String),
    /// Leaves a mode.
    LeaveMode(String),
    /// Ends everything that runs, in order: the manager is to stop.
    ShutDown,
}

/// What a telecommand is answered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reply {
    /// It was done.
    Done,
    /// It was not done, and nothing changed.
    Refused(String),
}
