//! What the ground writes: activities, and the limits of this plan.

mod effects;

use core::fmt;
use core::num::NonZeroU32;

use faregate_agents::Categories;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use serde::{Deserialize, Serialize};

use crate::units::{Bytes, Ppm, Span, Time};

pub use effects::{Constraint, Effect, Impact};

/// A plan file's content (slide "Onboard Planner Overview").
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// What people call it.
    pub name: String,
    /// When the next plan takes over. Not after `end`.
    pub handover: Time,
    /// Optional activities leave at least this much at handover.
    pub handover_min_soc: Ppm,
    /// Nothing runs after it.
    pub end: Time,
    /// Optional activities do not make more data than this.
    pub max_delta_data: Bytes,
    /// The file that takes over at handover.
    pub next_plan: Option<String>,
    /// In the file's order, which decides among equal priorities.
    pub activities: Vec<Activity>,
}

/// An activity's number, unique in the plan. 0 is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ActivityId(NonZeroU32);

impl ActivityId {
    /// The smallest number.
    pub const FIRST: Self = Self(NonZeroU32::MIN);

    /// The activity of this number; `None` for 0.
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

impl fmt::Display for ActivityId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "activity {}", self.0)
    }
}

/// What is scheduled (slides "Activity Types", "Activity Attributes").
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Activity {
    /// Its number.
    pub id: ActivityId,
    /// What people call it.
    pub name: Option<String>,
    /// What kind of activity it is.
    pub kind: Kind,
    /// The sequence that it runs, by name; none: it only holds resources.
    pub sequence: Option<String>,
    /// Larger is more important.
    pub priority: u32,
    /// What it is worth beside others, where that is not its priority.
    pub value: Option<u64>,
    /// How long it runs; an expanding activity: the longest.
    pub duration: Span,
    /// Average power beside the computer's and the base load.
    pub marginal: Milliwatts,
    /// The same as energy, where the ground says it, too.
    pub energy: Option<Microjoules>,
    /// Largest power.
    pub peak: Milliwatts,
    /// What it adds to the data on board; negative for a downlink.
    pub data: Bytes,
    /// How many sequence engines it uses at most.
    pub engines: u32,
    /// When it can start. Never empty.
    pub starts: Vec<StartRange>,
    /// What must have become of other activities first: all of these.
    pub after: Vec<Dependency>,
    /// Resource usage bits: none runs beside another with the same bit. They
    /// are the conflict categories of the ticket agents.
    pub resources: Categories,
    /// Thermal zones that it uses, by name: warm from its start to its end.
    pub zones: Vec<String>,
    /// Onboard variables that must be right when it is dispatched, and are not
    /// looked at before.
    pub conditions: Vec<Condition>,
    /// What it does to named timelines.
    pub impacts: Vec<Impact>,
    /// What it asks of named timelines while it runs.
    pub constraints: Vec<Constraint>,
    /// The single selection group that it belongs to, by name.
    pub group: Option<String>,
    /// Whether it can be paused when its tickets are taken.
    pub pausable: bool,
}

/// What kind of activity it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// Runs for its duration.
    #[default]
    Generic,
    /// Runs at least this long, at most for its duration: as long as the
    /// planner can let it.
    Expanding {
        /// The shortest duration that is worth it.
        minimum: Span,
    },
    /// Keeps the computer awake.
    StayAwake,
    /// Shutdown, sleep and wakeup at the ground's own times, one block from the
    /// first start of its first range to `duration` later.
    ManualShutdown {
        /// How long the shutdown takes, at the block's begin.
        shutdown: Span,
        /// How long the wakeup takes, at the block's end.
        wakeup: Span,
    },
    /// Runs when a prior one failed or was aborted, and establishes a known
    /// state.
    Cleanup,
}

/// When an activity can start, both ends inclusive, and when it must be over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct StartRange {
    /// The earliest start.
    pub from: Time,
    /// The latest start.
    pub to: Time,
    /// The latest end, running or paused.
    pub cutoff: Time,
}

/// What must have become of another activity.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Dependency {
    /// The other one.
    pub prior: ActivityId,
    /// Any of these.
    pub statuses: Vec<Status>,
}

/// What became of an activity, as a dependency names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Status {
    /// Did its work.
    Succeeded,
    /// Ended in a malfunction.
    Failed,
    /// Was ended by the control thread.
    Aborted,
    /// Its last start range closed, or it was vetoed for good.
    NotStarted,
    /// Succeeded or failed.
    Completed,
}

impl Status {
    /// Whether the outcome is one of these.
    #[must_use]
    pub const fn includes(self, outcome: Outcome) -> bool {
        matches!(
            (self, outcome),
            (Self::Succeeded | Self::Completed, Outcome::Succeeded)
                | (Self::Failed | Self::Completed, Outcome::Failed)
                | (Self::Aborted, Outcome::Aborted)
                | (Self::NotStarted, Outcome::NotStarted)
        )
    }
}

/// How an activity ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Outcome {
    /// Did its work.
    Succeeded,
    /// Ended in a malfunction.
    Failed,
    /// Was ended by the control thread.
    Aborted,
    /// Never started.
    NotStarted,
}

/// A variable that must lie in a range when an activity is dispatched.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Condition {
    /// Which kind of variable it is.
    pub kind: Variable,
    /// Its name. An unknown one is not satisfied.
    pub name: String,
    /// The smallest value, inclusive.
    pub min: i64,
    /// The largest value, inclusive.
    pub max: i64,
}

/// Onboard variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Variable {
    /// Saved over a reboot; typically allows or precludes some action.
    Acm,
    /// Not saved.
    Ddi,
}

impl Activity {
    /// A generic activity that uses nothing, at priority 0, that can start at
    /// any time.
    #[must_use]
    pub fn new(id: ActivityId, duration: Span) -> Self {
        let always = StartRange {
            from: Time::ZERO,
            to: Time::new(i64::MAX / 4),
            cutoff: Time::new(i64::MAX / 2),
        };
        Self {
            id,
            name: None,
            kind: Kind::Generic,
            sequence: None,
            priority: 0,
            value: None,
            duration,
            marginal: Milliwatts::ZERO,
            energy: None,
            peak: Milliwatts::ZERO,
            data: Bytes::ZERO,
            engines: 0,
            starts: vec![always],
            after: Vec::new(),
            resources: Categories::NONE,
            zones: Vec::new(),
            conditions: Vec::new(),
            impacts: Vec::new(),
            constraints: Vec::new(),
            group: None,
            pausable: false,
        }
    }

    /// The duration that it is placed with: an expanding one's minimum.
    #[must_use]
    pub const fn placed(&self) -> Span {
        match self.kind {
            Kind::Expanding { minimum } => minimum,
            _ => self.duration,
        }
    }

    /// What it is worth: its value, or else its priority.
    #[must_use]
    pub fn worth(&self) -> u64 {
        self.value.unwrap_or(u64::from(self.priority))
    }
}
