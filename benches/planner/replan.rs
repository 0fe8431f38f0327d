//! Row 20: planning again after an activity ended early.

use std::hint::black_box;
use std::time::{Duration, Instant};

use faregate_planner::generate::{Shape, World};
use faregate_planner::{Problem, TimedPlan, schedule};

use crate::later::{early_one, later};
use crate::problem;
use crate::support::{Bench, Failure, Quantiles, Target};

const ACTIVITIES: usize = 1_000;
const WORLDS: u64 = 5;

/// What one world says.
struct Again {
    /// With the plan that is being executed, in seconds.
    again: f64,
    /// The same state, and no plan.
    anew: f64,
    /// How many of the activities that are still to come are planned as before.
    alike: f64,
}

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let all: Result<Vec<Again>, Failure> =
        (0..WORLDS).map(|seed| again(&Shape::sols(ACTIVITIES, seed).draw())).collect();
    let all = all?;
    let median = |of: fn(&Again) -> f64| Quantiles::of(all.iter().map(of).collect()).median;
    let name = "planning again, one of the first tenth of 1000 activities ended early";
    bench.figure(20, name, median(|one| one.again) * 1e3, "ms", Target::None);
    let name = "planning anew, the same state";
    bench.figure(20, name, median(|one| one.anew) * 1e3, "ms", Target::None);
    let name = "planning again / planning anew";
    bench.figure(20, name, median(|one| one.again / one.anew), "x", Target::AtMost(0.2));
    let name = "activities to come that are planned as they were before";
    bench.figure(20, name, median(|one| one.alike) * 100.0, "%", Target::None);
    Ok(())
}

fn again(world: &World) -> Result<Again, Failure> {
    let timed = schedule(&problem(world)?, None);
    let early = early_one(&world.plan, &timed).ok_or("no activity can end early")?;
    let later = later(world, &timed, early)?;
    let problem = problem(&later)?;
    let again = schedule(&problem, Some(&timed));
    Ok(Again {
        again: least(|| schedule(&problem, Some(&timed))),
        anew: least(|| schedule(&problem, None)),
        alike: alike(&problem, &timed, &again),
    })
}

/// The least of three, in seconds.
fn least(plan: impl Fn() -> TimedPlan) -> f64 {
    let sample = |_| {
        let start = Instant::now();
        black_box(plan());
        start.elapsed()
    };
    (0..3).map(sample).min().unwrap_or(Duration::ZERO).as_secs_f64()
}

/// Which part of the candidates has the slot that it had, or none as before.
fn alike(problem: &Problem, before: &TimedPlan, after: &TimedPlan) -> f64 {
    let order = problem.order();
    let id = |item: usize| problem.plan().activities[item].id;
    let same = order.iter().filter(|&&item| before.slot(id(item)) == after.slot(id(item)));
    same.count() as f64 / order.len() as f64
}
