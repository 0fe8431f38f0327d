//! How crowded a world is: what candidates find at their turns.

use faregate_planner::generate::World;
use faregate_planner::timed::{Fate, Limit, Reason};
use faregate_planner::timeline::{Claim, Timelines};
use faregate_planner::units::Time;
use faregate_planner::{Activity, schedule_in_order};

use crate::problem;
use crate::support::Failure;

/// Sums over candidates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tightness {
    candidates: u32,
    intervals: u32,
    charge: u32,
    starts: u64,
}

impl Tightness {
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            candidates: self.candidates + other.candidates,
            intervals: self.intervals + other.intervals,
            charge: self.charge + other.charge,
            starts: self.starts + other.starts,
        }
    }

    /// How many intervals of starts a candidate finds, before the charge is
    /// asked.
    pub(crate) fn intervals(self) -> f64 {
        f64::from(self.intervals) / f64::from(self.candidates)
    }

    /// How many of them the charge keeps out, or from their first such start:
    /// with it, what it asks for: lead time, and awake time of its own.
    pub(crate) fn bound_by_charge(self) -> f64 {
        f64::from(self.charge) / f64::from(self.candidates)
    }
}

impl Tightness {
    /// How many starts are tried for one, all its turns together.
    pub(crate) fn starts(self) -> f64 {
        self.starts as f64 / f64::from(self.candidates)
    }
}

/// Walks through what the pass decided, in its order.
pub(crate) fn tightness(world: &World) -> Result<Tightness, Failure> {
    let (problem, plan) = (problem(world)?, &world.plan);
    let (timed, effort) = schedule_in_order(&problem, problem.order(), None);
    let mut timelines = Timelines::new(plan, &world.parameters, &world.state);
    for (order, window) in (plan.activities.len()..).zip(&world.state.windows) {
        timelines.insert(&Claim::window(window, order), window.start);
    }
    let mut sum = Tightness { starts: effort.starts, ..Tightness::default() };
    for &item in problem.order() {
        let activity = &plan.activities[item];
        let claim = Claim::of(activity, item, activity.placed(), &world.parameters)?;
        let valid = valid(&timelines, &claim, activity, plan.end);
        sum.candidates += 1;
        sum.intervals += valid.0;
        match &timed.rows[item].fate {
            Fate::Scheduled(slot) => {
                timelines.insert(&claim, slot.start);
                // Dependants wait for others, whatever the charge.
                let waits = !activity.after.is_empty();
                sum.charge += u32::from(!waits && valid.1.is_some_and(|first| first < slot.start));
            }
            Fate::Out(Reason::Limit { limit, .. }) => {
                let charge = matches!(limit, Limit::SoftMinimum | Limit::Handover);
                sum.charge += u32::from(charge);
            }
            _ => {}
        }
    }
    Ok(sum)
}

/// How many intervals of starts, and the first start.
fn valid(
    timelines: &Timelines,
    claim: &Claim,
    activity: &Activity,
    end: Time,
) -> (u32, Option<Time>) {
    let ranges = activity.starts.iter().map(|range| {
        let last = range.to.min(range.cutoff.min(end).before(activity.placed()));
        timelines.valid_starts(claim, (range.from, last))
    });
    let all = ranges.reduce(|a, b| a.union(&b)).unwrap_or_default();
    (u32::try_from(all.len()).unwrap_or(u32::MAX), all.first())
}
