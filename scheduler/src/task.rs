//! What a task is: fields, bodies and policies.
//!
//! SMAARTE's columns (Gillette 2019, table 1) are all here; what it lacks has a
//! default that means what SMAARTE does.

use core::fmt;
use core::num::NonZeroU32;

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;
use serde::{Deserialize, Serialize};

use crate::time::{Duration, UnixTime};

/// A task's number, unique in the schedule. 0 is not a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct TaskId(NonZeroU32);

impl TaskId {
    /// The task of this number; `None` for 0.
    #[must_use]
    pub const fn new(number: u32) -> Option<Self> {
        match NonZeroU32::new(number) {
            Some(number) => Some(Self(number)),
            None => None,
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0.get()
    }
}

impl fmt::Display for TaskId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "task {}", self.0)
    }
}

/// How important a task is, 0 to 239; larger is more important. Levels from 240
/// are for fault responses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TaskPriority(u8);

impl TaskPriority {
    /// The most important that a task can be. A task that cannot be pre-empted
    /// holds its tickets there.
    pub const TOP: Self = Self(239);

    /// The priority of this level; `None` above 239.
    #[must_use]
    pub const fn new(level: u8) -> Option<Self> {
        if level <= Self::TOP.0 { Some(Self(level)) } else { None }
    }

    /// The level.
    #[must_use]
    pub const fn level(self) -> u8 {
        self.0
    }
}

/// A point in time as a schedule says it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum When {
    /// No restriction (`0`).
    #[default]
    Unrestricted,
    /// So long after the schedule was loaded, or the task was accepted (`+30`).
    AfterLoad(Duration),
    /// At this time of day (Unix seconds, or RFC 3339).
    At(UnixTime),
}

/// When an attempt may start, both ends inclusive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Window {
    /// The earliest start (`st`).
    pub opens: When,
    /// The latest start (`et`).
    pub closes: When,
}

/// What a task does when it is dispatched.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Body {
    /// A program, executed without a shell.
    Process {
        /// The program: a path, or a name that is looked up in `PATH`.
        program: String,
        /// Its arguments, the program's own name not among them.
        arguments: Vec<String>,
    },
    /// A function that the program registered under this type number (16 or
    /// more).
    Function {
        /// SMAARTE's `type`.
        number: u16,
        /// What it is given.
        arguments: Vec<String>,
    },
    /// Commands at times (what cFS calls a relative time sequence).
    Sequence(Vec<Step>),
    /// Nothing: occupies its categories and its draw for its duration.
    Hold,
    /// A function of the manager itself.
    BuiltIn(BuiltIn),
}

/// One command of a sequence.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Step {
    /// When, from the start of the sequence; time paused does not count.
    pub offset: Duration,
    /// The gate.
    pub gate: String,
    /// The command's name.
    pub command: String,
    /// The command's arguments.
    pub arguments: Vec<String>,
    /// Whether the sequence goes on when this command is refused.
    pub continues: bool,
}

/// What the manager can do by itself.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum BuiltIn {
    /// Drops what is pending; with `all` ends what runs, too (type 1).
    Clear {
        /// Whether what runs ends, too.
        all: bool,
    },
    /// Removes these tasks (type 2).
    Remove(Vec<TaskId>),
    /// Loads a schedule file, beside what is there (type 3).
    Load(String),
    /// Enters a mode of the mission (type 4).
    EnterMode(String),
    /// Leaves a mode of the mission (type 5).
    LeaveMode(String),
}

/// What happens to a task whose tickets are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Preemption {
    /// No task takes its tickets. Fault responses do, and then it is killed.
    Wait,
    /// Its processes are stopped where they are, and go on later.
    Pause,
    /// It is told, given this long to save its work, and run again later.
    Checkpoint {
        /// How long.
        grace: Duration,
        /// Which signal tells it.
        signal: CheckpointSignal,
    },
    /// It is terminated, after this long killed, and run again from the start.
    Kill {
        /// How long between SIGTERM and SIGKILL.
        grace: Duration,
    },
}

/// The signal that asks a process to save its work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum CheckpointSignal {
    /// SIGUSR1.
    #[default]
    User1,
    /// SIGUSR2.
    User2,
    /// SIGTERM.
    Terminate,
    /// SIGHUP.
    HangUp,
    /// SIGINT.
    Interrupt,
}

/// What happens after a malfunction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Restart {
    /// The occurrence has failed: at most once.
    #[default]
    Never,
    /// It is tried again: at least once.
    OnFailure {
        /// At most this often, after the first attempt.
        limit: u32,
        /// After this long.
        back_off: Duration,
    },
}

/// What happens when a task runs longer than its duration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Overrun {
    /// It is reported.
    #[default]
    Report,
    /// The run is aborted.
    Abort,
    /// The run is aborted, which counts as a failure, and the restart policy
    /// decides.
    AbortAndRestart,
}

/// How an occurrence of a task can end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Outcome {
    /// It did its work.
    Succeeded,
    /// It ended in a malfunction.
    Failed,
    /// It was ended: a cutoff, an overrun, a telecommand.
    Aborted,
    /// It never started, or not again: its window closed.
    Missed,
}

/// Which outcomes of another task satisfy a dependant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Status {
    /// Succeeded.
    Succeeded,
    /// Failed.
    Failed,
    /// Aborted.
    Aborted,
    /// Missed.
    Missed,
    /// Succeeded or failed.
    Completed,
    /// Succeeded, failed or aborted.
    Finished,
}

impl Status {
    /// Whether the outcome is one of these.
    #[must_use]
    pub const fn includes(self, outcome: Outcome) -> bool {
        matches!(
            (self, outcome),
            (Self::Succeeded | Self::Completed | Self::Finished, Outcome::Succeeded)
                | (Self::Failed | Self::Completed | Self::Finished, Outcome::Failed)
                | (Self::Aborted | Self::Finished, Outcome::Aborted)
                | (Self::Missed, Outcome::Missed)
        )
    }
}

/// What must have become of another task first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Dependency {
    /// The other task.
    pub task: TaskId,
    /// What must have become of it.
    pub status: Status,
}

/// Shortest and longest duration, for samples (a triangle with its mode at the
/// expected duration).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Spread {
    /// The shortest.
    pub shortest: Duration,
    /// The longest.
    pub longest: Duration,
}

/// A task of the schedule.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Task {
    /// Its number.
    pub id: TaskId,
    /// What people call it.
    pub name: Option<String>,
    /// When an attempt may start. The first open window counts. Never empty.
    pub windows: Vec<Window>,
    /// The latest end, running or paused.
    pub cutoff: When,
    /// The expected time of running, pauses not counted; none: not stated.
    pub duration: Duration,
    /// How much it varies; none: not at all.
    pub spread: Option<Spread>,
    /// One running task for each category.
    pub categories: Categories,
    /// How important it is.
    pub priority: TaskPriority,
    /// From one occurrence to the next; none: it runs once.
    pub interval: Option<Duration>,
    /// What it does.
    pub body: Body,
    /// Bytes of memory reserved from dispatch to end.
    pub memory: u64,
    /// Bytes of storage reserved from dispatch to end.
    pub storage: u64,
    /// The lowest state of charge at which it may be dispatched, in percent.
    pub battery: u8,
    /// Its own largest draw, its devices' not included.
    pub peak_draw: Milliwatts,
    /// Its own average draw.
    pub average_draw: Milliwatts,
    /// Bytes of data that it produces.
    pub data: u64,
    /// The gates that it commands, by name.
    pub gates: Vec<String>,
    /// How long after its end it keeps its categories.
    pub gap: Duration,
    /// What happens when its tickets are taken.
    pub preemption: Preemption,
    /// What happens after a malfunction.
    pub restart: Restart,
    /// What happens when it runs too long.
    pub overrun: Overrun,
    /// How often it says that it is alive, where that is agreed.
    pub heartbeat: Option<Duration>,
    /// What must have become of other tasks first.
    pub after: Vec<Dependency>,
    /// The task that runs when this one failed or was aborted. It has no times
    /// of its own.
    pub cleanup: Option<TaskId>,
    /// Whether the mission needs it.
    pub mandatory: bool,
}

impl Task {
    /// A task with SMAARTE's defaults: starts when it can, once, conflicts with
    /// nothing, at priority 0. A process is paused when its tickets are taken;
    /// anything else cannot be pre-empted.
    #[must_use]
    pub fn new(id: TaskId, body: Body) -> Self {
        let preemption = match body {
            Body::Process { .. } | Body::Hold | Body::Sequence(_) => Preemption::Pause,
            Body::Function { .. } | Body::BuiltIn(_) => Preemption::Wait,
        };
        Self {
            id,
            name: None,
            windows: vec![Window::default()],
            cutoff: When::Unrestricted,
            duration: Duration::ZERO,
            spread: None,
            categories: Categories::NONE,
            priority: TaskPriority::default(),
            interval: None,
            body,
            memory: 0,
            storage: 0,
            battery: 0,
            peak_draw: Milliwatts::ZERO,
            average_draw: Milliwatts::ZERO,
            data: 0,
            gates: Vec::new(),
            gap: Duration::ZERO,
            preemption,
            restart: Restart::Never,
            overrun: Overrun::Report,
            heartbeat: None,
            after: Vec::new(),
            cleanup: None,
            mandatory: false,
        }
    }
}
