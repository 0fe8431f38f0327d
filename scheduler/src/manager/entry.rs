//! A task as the manager keeps it, with its one occurrence.

use crate::manager::classes::ClassId;
use crate::manager::point::{Micros, Point, Present};
use crate::manager::rank::Rank;
use crate::manager::{Attempt, Occurrence, Stop, WaitsFor, timers};
use crate::task::{Body, BuiltIn, Outcome, Task, TaskId};

/// A task of the schedule.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) task: Task,
    pub(crate) load: u32,
    pub(crate) position: u64,
    /// When it was accepted: what `+N` counts from.
    pub(crate) accepted: Present,
    pub(crate) class: ClassId,
    /// The number of the present occurrence, and of the one after it.
    pub(crate) current: u64,
    pub(crate) next: u64,
    /// So many occurrences were due again because the time of day was set back:
    /// a number stands for the time of the one that many before it.
    pub(crate) back: u64,
    pub(crate) place: Place,
    /// When the present occurrence became due, or will.
    pub(crate) arrival: Micros,
    /// When it may start: its window opens, or its back-off is over.
    pub(crate) due: Point,
    /// Attempts of the present occurrence that began.
    pub(crate) attempts: u32,
    /// How many of them failed.
    pub(crate) failures: u32,
    /// The last one was checkpointed: the next goes on with what that saved,
    /// and is no start that a window is needed for.
    pub(crate) saved: bool,
    pub(crate) held: bool,
    /// It leaves the schedule when its body has ended.
    pub(crate) removed: bool,
    /// That it will start when it is due is in the journal.
    pub(crate) armed: bool,
    /// Is started by the failure of another task, and not by time.
    pub(crate) cleans_up: bool,
    /// Priors that are gone, and whose last outcomes it has: for one start.
    pub(crate) gone: Vec<TaskId>,
    /// Which dependencies are satisfied, in the task's order.
    pub(crate) satisfied: Vec<bool>,
    pub(crate) misses: Option<Misses>,
    pub(crate) last: Option<Outcome>,
    /// What was last told of what it waits for.
    pub(crate) told: Option<WaitsFor>,
    pub(crate) run: Run,
    pub(crate) timers: timers::Set,
}

/// Where the present occurrence is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Nowhere: something must happen first (a dependency, a telecommand).
    Away,
    /// With its class, due or not.
    Class,
    /// It was asked for at the agents, or has a body.
    Live,
    /// There is none, and will be none.
    Over,
}

/// What is known of an occurrence that is live.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) stage: Stage,
    pub(crate) asked: Asked,
    /// How long the attempt ran before it was last let go on.
    pub(crate) ran: Micros,
    /// Since when it runs, if it does.
    pub(crate) since: Micros,
    pub(crate) overran: bool,
    /// It is kept from running until a shortage is over.
    pub(crate) short: bool,
    /// Who was told to take its tickets.
    pub(crate) taker: Option<Occurrence>,
    /// What the last decision said: it runs, or why not.
    pub(crate) chosen: Result<(), WaitsFor>,
    /// Its request at the agents has another priority than the task by now.
    pub(crate) stale: bool,
}

/// What the body of a live occurrence does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// There is none.
    Idle,
    Running,
    Stopping {
        how: Stop,
        then: Then,
    },
    Paused,
    /// It should have returned, and has not.
    Runaway(Then),
}

/// What the end of a body that is being stopped means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Then {
    /// It will go on, or be run again.
    Again,
    /// The occurrence was ended.
    Abort,
    /// The attempt failed.
    Fail,
}

/// Where the request for its tickets stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    No,
    Waiting,
    /// It waits for something that is not in the manager's hands.
    Blocked(String),
    Granted,
}

/// Occurrences that were missed one after the other for one reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Misses {
    pub(crate) first: u64,
    pub(crate) last: u64,
    pub(crate) count: u64,
    pub(crate) why: &'static str,
}

impl Run {
    pub(crate) const fn new() -> Self {
        Self {
            stage: Stage::Idle,
            asked: Asked::No,
            ran: 0,
            since: 0,
            overran: false,
            short: false,
            taker: None,
            chosen: Ok(()),
            stale: false,
        }
    }

    /// Whether there is a body.
    pub(crate) fn has_body(&self) -> bool {
        self.stage != Stage::Idle
    }

    /// Whether the body may still be using what it was given.
    pub(crate) const fn is_using(&self) -> bool {
        matches!(self.stage, Stage::Running | Stage::Stopping { .. } | Stage::Runaway(_))
    }

    /// Whether the body is to end for good.
    pub(crate) fn is_ending(&self) -> bool {
        match &self.stage {
            Stage::Stopping { then, .. } | Stage::Runaway(then) => *then != Then::Again,
            _ => false,
        }
    }
}

impl Entry {
    pub(crate) fn occurrence(&self) -> Occurrence {
        Occurrence { task: self.task.id, load: self.load, number: self.current }
    }

    /// The attempt that runs, or ran last.
    pub(crate) fn attempt(&self) -> Attempt {
        Attempt { occurrence: self.occurrence(), number: self.attempts }
    }

    pub(crate) fn rank(&self) -> Rank {
        Rank::new(self.task.priority, self.arrival, self.position)
    }

    /// Whether its body is something that the manager does by itself, at once.
    pub(crate) const fn is_built_in(&self) -> bool {
        match &self.task.body {
            Body::BuiltIn(built_in) => !matches!(built_in, BuiltIn::Load(_)),
            _ => false,
        }
    }

    pub(crate) fn is_routine(&self) -> bool {
        self.task.interval.is_some_and(|interval| !interval.is_zero())
    }
}
