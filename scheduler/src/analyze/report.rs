//! What an analysis found. Serialised, all times are seconds from the load.

use core::fmt;

use faregate_agents::Categories;
use serde::{Serialize, Serializer};

use crate::analyze::samples::Samples;
use crate::analyze::utilisation::Utilisation;
use crate::task::TaskId;
use crate::time::Duration;

/// What becomes of a schedule, if all goes as expected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Analysis {
    /// When the last run of a task that is not routine ends; none: there is no
    /// such run.
    #[serde(rename = "makespan_s", serialize_with = "seconds_or_null")]
    pub makespan: Option<Duration>,
    /// The tasks, in the order of the schedule.
    pub tasks: Vec<TaskReport>,
    /// What should be looked at, in order of time.
    pub problems: Vec<Problem>,
    /// What varies, where samples were drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<Samples>,
    /// Until when it was looked at.
    #[serde(skip)]
    pub horizon: Duration,
    /// How much of the time is used of what.
    #[serde(skip)]
    pub utilisation: Utilisation,
}

/// What becomes of a task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TaskReport {
    /// Its number.
    pub id: TaskId,
    /// Its attempts, in order of time.
    pub runs: Vec<Run>,
    /// How long it was due and did not run, pauses included, over all its
    /// occurrences.
    #[serde(rename = "waited_s", serialize_with = "seconds")]
    pub waited: Duration,
    /// What it waited for the longest, or why it never runs; none: it never
    /// waited.
    pub reason: Option<String>,
    /// What pictures show beside.
    #[serde(skip)]
    pub more: Picture,
}

/// What pictures show of a task, beside its runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// What people call it, or the program that it runs.
    pub name: Option<String>,
    /// How important it is.
    pub priority: u8,
    /// Its categories.
    pub categories: Categories,
    /// How long it keeps them after its end.
    pub gap: Duration,
    /// When attempts may start: from, until.
    pub windows: Vec<(Duration, Option<Duration>)>,
    /// When it was due and had not started, or was to be run again.
    pub waits: Vec<(Duration, Duration)>,
    /// When an occurrence was missed.
    pub misses: Vec<Duration>,
    /// Whether it comes again and again.
    pub routine: bool,
}

/// One attempt.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Run {
    /// When it started.
    #[serde(rename = "start_s", serialize_with = "seconds")]
    pub start: Duration,
    /// When it ended; none: it had not, at the horizon.
    #[serde(rename = "end_s", serialize_with = "seconds_or_null")]
    pub end: Option<Duration>,
    /// How it ended.
    pub outcome: RunOutcome,
    /// When it did not stand still.
    #[serde(serialize_with = "pairs")]
    pub segments: Vec<(Duration, Duration)>,
    /// Which occurrence of the task it was.
    #[serde(skip)]
    pub occurrence: u64,
}

/// How an attempt ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunOutcome {
    /// It did its work.
    Succeeded,
    /// It ended in a malfunction.
    Failed,
    /// It was ended.
    Aborted,
    /// Its tickets were taken, and it will be run again.
    Preempted,
    /// It had not ended at the horizon.
    Unfinished,
}

impl fmt::Display for RunOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Aborted => "aborted",
            Self::Preempted => "preempted",
            Self::Unfinished => "unfinished",
        })
    }
}

/// Something that whoever wrote the schedule may not have meant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// What kind of thing.
    pub kind: ProblemKind,
    /// Which task has it.
    pub task: Option<TaskId>,
    /// With which other task.
    pub with: Option<TaskId>,
    /// When first.
    #[serde(rename = "at_s", serialize_with = "seconds_or_null")]
    pub at: Option<Duration>,
    /// How often; none: not at regular intervals.
    #[serde(rename = "every_s", serialize_with = "seconds_or_null")]
    pub every: Option<Duration>,
    /// In words.
    pub message: String,
}

impl Problem {
    /// A problem of the whole schedule.
    pub(super) fn new(kind: ProblemKind, message: String) -> Self {
        Self { kind, task: None, with: None, at: None, every: None, message }
    }

    pub(super) fn of(mut self, task: TaskId) -> Self {
        self.task = Some(task);
        self
    }

    pub(super) fn with(mut self, other: TaskId) -> Self {
        self.with = Some(other);
        self
    }

    pub(super) fn at(mut self, at: Duration) -> Self {
        self.at = Some(at);
        self
    }

    pub(super) fn every(mut self, every: Option<Duration>) -> Self {
        self.every = every;
        self
    }
}

/// What can be wrong with a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProblemKind {
    /// The task can never run, or had no chance to.
    NeverRuns,
    /// An occurrence did not start in its windows.
    Missed,
    /// A run was ended by its cutoff.
    Cutoff,
    /// A run took longer than its duration.
    Overrun,
    /// Two routine tasks want the same at regular intervals.
    Collision,
    /// Wishes for draw exceed the supply.
    Margin,
    /// A task waits for a less important one.
    Inversion,
    /// The duration is not stated: it is taken to be 0.
    NoDuration,
    /// The task had not run at the horizon.
    Waiting,
    /// Samples were wanted, and no duration has a spread.
    NoSpread,
    /// There is more than was looked at, or is listed.
    More,
}

impl fmt::Display for ProblemKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NeverRuns => "never runs",
            Self::Missed => "missed",
            Self::Cutoff => "cutoff",
            Self::Overrun => "overrun",
            Self::Collision => "collision",
            Self::Margin => "margin",
            Self::Inversion => "inversion",
            Self::NoDuration => "no duration",
            Self::Waiting => "waiting",
            Self::NoSpread => "no spread",
            Self::More => "more",
        })
    }
}

/// As seconds, which every microsecond of a century has its own number of.
#[expect(clippy::cast_precision_loss, reason = "exact below 2^53 us, which is 285 years")]
pub(super) fn as_seconds(duration: Duration) -> f64 {
    duration.as_micros() as f64 / 1e6
}

pub(super) fn seconds<S: Serializer>(duration: &Duration, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f64(as_seconds(*duration))
}

fn seconds_or_null<S: Serializer>(duration: &Option<Duration>, to: S) -> Result<S::Ok, S::Error> {
    duration.map(as_seconds).serialize(to)
}

fn pairs<S: Serializer>(pairs: &[(Duration, Duration)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(pairs.iter().map(|(from, until)| [as_seconds(*from), as_seconds(*until)]))
}
