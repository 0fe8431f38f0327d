//! What the planner answers: when everything runs, and why some does not.

use serde::{Deserialize, Serialize};

use crate::plan::{ActivityId, Outcome};
use crate::units::{Span, Time};

/// A timed plan.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimedPlan {
    /// One row for each activity of the plan, in its order.
    pub rows: Vec<Row>,
    /// When the computer is up, in order.
    pub awake: Vec<AwakePhase>,
    /// What is heated, in order of start, then of the zone's name.
    pub preheats: Vec<Preheat>,
    /// Limits that mandatory activities exceed because they may.
    pub excess: Vec<Excess>,
    /// Limits that are broken whatever is planned.
    pub unavoidable: Vec<Excess>,
}

/// What the plan does with an activity.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// Which activity.
    pub id: ActivityId,
    /// What becomes of it.
    pub fate: Fate,
}

/// What becomes of an activity.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fate {
    /// It runs then.
    Scheduled(Slot),
    /// It runs already.
    Running(Slot),
    /// It has ended.
    Ended(Outcome),
    /// It is left out.
    Out(Reason),
}

/// When an activity runs: half-open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Slot {
    /// Its start.
    pub start: Time,
    /// Its end.
    pub end: Time,
    /// Which of its start ranges it uses.
    pub range: usize,
}

/// Why an activity is left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reason {
    /// Every start breaks a limit: the one that blocks the earliest start that
    /// its ranges, its dependencies and its group leave.
    Limit {
        /// Which limit.
        limit: Limit,
        /// When it would be broken.
        at: Time,
        /// By how much, in the limit's unit (uJ, B, mW, engines, ms).
        amount: i64,
        /// Who is in the way, where that can be said.
        with: Option<ActivityId>,
    },
    /// Its last start range is over, or no start in it ends by its cutoff.
    NoRangeLeft,
    /// An activity that it depends on is left out.
    PriorOut(ActivityId),
    /// An activity that it depends on ended otherwise.
    PriorEnded(ActivityId, Outcome),
    /// An activity that it depends on is planned, and nobody knows yet how it
    /// ends.
    WaitsForOutcome(ActivityId),
    /// Another member of its group was selected.
    GroupTaken(ActivityId),
    /// It would start within the commit window, and the present plan has not
    /// got it there.
    Committed,
    /// The next plan took over before it began.
    HandedOver,
}

/// The limits, in the order in which relaxations are listed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Limit {
    /// The soft minimum of the state of charge, in uJ of charge.
    SoftMinimum,
    /// The minimum at handover, in uJ of charge.
    Handover,
    /// The data volume of the plan, in bytes.
    Data,
    /// The sum of peaks, in mW.
    Peak,
    /// Sequence engines.
    Engines,
    /// Resource usage bits: a mask of those that are held.
    Resources(u128),
    /// A named timeline.
    Timeline(String),
    /// Nothing else runs in a wakeup, a shutdown or a manual sleep.
    Computer,
    /// There is no time left for a wakeup or for heating before the start.
    Lead,
    /// A start range or its cutoff.
    Range,
    /// A dependency.
    Dependency,
}

/// The computer is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct AwakePhase {
    /// Waking up begins; equal to `up` where it is up at the plan's begin.
    pub wakeup: Time,
    /// It is up.
    pub up: Time,
    /// Shutting down begins.
    pub down: Time,
    /// It is asleep; equal to `down` where the plan ends before.
    pub asleep: Time,
}

/// A thermal zone is heated: half-open.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Preheat {
    /// The zone's name.
    pub zone: String,
    /// From then.
    pub start: Time,
    /// Until its use.
    pub end: Time,
}

/// A limit that is exceeded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Excess {
    /// By which activity; none: by what nobody decides.
    pub by: Option<ActivityId>,
    /// Which limit.
    pub limit: Limit,
    /// When first.
    pub at: Time,
    /// By how much, in the limit's unit.
    pub amount: i64,
}

/// What timelines will be, if all goes as planned.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Projection {
    /// One for each timeline: charge, peak, data, engines, awake, then the named
    /// ones.
    pub lines: Vec<Line>,
}

/// The values of a timeline.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// Its name.
    pub name: String,
    /// What it counts: uJ, mW, B, or nothing.
    pub unit: String,
    /// Whether values change at once, and not in straight lines from point to
    /// point.
    pub steps: bool,
    /// Values at instants, in order; of two at the same instant the later one
    /// holds from then on.
    pub points: Vec<(Time, i64)>,
}

impl Line {
    /// The value at an instant: that of the first point before there is one, and
    /// of the last one after it. Between points, what is no state goes in a
    /// straight line, rounded towards the earlier value.
    #[must_use]
    pub fn at(&self, at: Time) -> Option<i64> {
        let later = self.points.partition_point(|(point, _)| *point <= at);
        let after = self.points.get(later);
        let before = later.checked_sub(1).and_then(|index| self.points.get(index));
        match (before, after) {
            (Some((t0, y0)), Some((t1, y1))) if !self.steps => {
                let part = i128::from(at.since(*t0).get()) * (i128::from(*y1) - i128::from(*y0));
                let more = part / i128::from(t1.since(*t0).get().max(1));
                Some(y0.saturating_add(i64::try_from(more).unwrap_or(i64::MAX)))
            }
            (Some((_, value)), _) | (None, Some((_, value))) => Some(*value),
            (None, None) => None,
        }
    }
}

impl TimedPlan {
    /// When an activity runs, if it does.
    #[must_use]
    pub fn slot(&self, id: ActivityId) -> Option<Slot> {
        let row = self.rows.iter().find(|row| row.id == id)?;
        match row.fate {
            Fate::Scheduled(slot) | Fate::Running(slot) => Some(slot),
            Fate::Ended(_) | Fate::Out(_) => None,
        }
    }
}

impl Slot {
    /// How long it runs.
    #[must_use]
    pub const fn length(self) -> Span {
        self.end.since(self.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(steps: bool) -> Line {
        let point = |at, value| (Time::new(at), value);
        let points = vec![point(10, 100), point(20, 0), point(20, 50), point(30, 53)];
        Line { name: "charge".into(), unit: "uJ".into(), steps, points }
    }

    #[test]
    fn a_value_is_that_of_the_straight_line_or_of_the_last_step() {
        let values = |steps| [0, 10, 15, 20, 25, 30, 99].map(|at| line(steps).at(Time::new(at)));
        assert_eq!(values(false), [100, 100, 50, 50, 51, 53, 53].map(Some));
        assert_eq!(values(true), [100, 100, 100, 50, 50, 53, 53].map(Some));
        assert_eq!(Line { points: Vec::new(), ..line(true) }.at(Time::ZERO), None);
    }
}
