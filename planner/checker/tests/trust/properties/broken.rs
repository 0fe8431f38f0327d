//! Planners that are broken: each so that one property does not hold.

use std::sync::atomic::{AtomicU64, Ordering};

use faregate_planner::schedule::{Budget, Improved, Worth, improve, schedule, schedule_in_order};
use faregate_planner::{Problem, TimedPlan};

use super::{Planner, RIGHT};

/// It throws dice that nobody gave it.
pub(super) const MOODY: Planner = Planner {
    improve: |problem, old, budget| {
        static TURN: AtomicU64 = AtomicU64::new(0);
        let seed = TURN.fetch_add(1, Ordering::Relaxed);
        improve(problem, old, Budget { seed, ..budget }, &mut || false)
    },
    ..RIGHT
};

/// It goes by how many activities there are.
pub(super) const COUNTING: Planner = Planner {
    schedule: |problem, old| {
        let mut order = problem.order().to_vec();
        if problem.plan().activities.len() % 2 == 1 {
            order.reverse();
        }
        schedule_in_order(problem, &order, old).0
    },
    ..RIGHT
};

/// It takes the last plan that it has tried for the best.
pub(super) const CARELESS: Planner = Planner { improve: careless, ..RIGHT };

fn careless(problem: &Problem, old: Option<&TimedPlan>, _: Budget) -> Improved {
    let mut order = problem.order().to_vec();
    order.reverse();
    let (timed, effort) = schedule_in_order(problem, &order, old);
    let worth = Worth::of(problem, &timed);
    Improved { timed, worth, evaluations: effort.candidates, rounds: 1 }
}

/// It forgets the plan that is being executed, but for its commit window.
pub(super) const FORGETFUL: Planner = Planner {
    schedule: |problem, old| schedule_in_order(problem, problem.order(), old).0,
    ..RIGHT
};

/// It says that its plan is worth more than it is.
pub(super) const BOASTING: Planner = Planner {
    improve: |problem, old, budget| {
        let improved = improve(problem, old, budget, &mut || false);
        Improved { timed: schedule(problem, old), ..improved }
    },
    ..RIGHT
};
