//! How long an activity becomes that can be made longer, against trying every
//! millisecond, where what happens at its end is in the way of others at some
//! ends and not at later ones.

use faregate_checker::reference;
use faregate_planner::plan::{Constraint, Effect, Impact, Kind};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::units::Span;
use faregate_planner::{Activity, Problem, schedule};
use fastrand::Rng;

use crate::brute::{seeds, told};
use crate::planner::{bare, difference};
use crate::worlds::{TINY, World, world};

pub(crate) fn impact(timeline: &str, effect: Effect) -> Impact {
    Impact { timeline: timeline.into(), effect }
}

/// It can become a lot longer, and what it does at its end matters to others.
fn stretch(activity: &mut Activity, rng: &mut Rng) {
    let minimum = activity.placed();
    activity.kind = Kind::Expanding { minimum };
    let more = Span::new(rng.i64(10..60));
    activity.duration = Span::new(minimum.get() + more.get());
    for range in &mut activity.starts {
        range.cutoff = range.cutoff.after(more);
    }
    let mode = impact("mode", Effect::SetAtEnd(rng.i64(0..=3)));
    activity.impacts = match rng.u8(0..4) {
        0 => vec![mode],
        1 => {
            let rate = Effect::Rate(rng.i64(-600..600));
            let end = Effect::AddAtEnd(rng.i64(-12..12));
            vec![impact("fuel", rate), impact("fuel", end)]
        }
        2 => vec![
            impact("fuel", Effect::AddAtStart(rng.i64(-12..12))),
            impact("fuel", Effect::AddAtEnd(rng.i64(-12..12))),
            mode,
        ],
        _ => vec![impact("seats", Effect::Hold(rng.i64(1..=3)))],
    };
}

/// It asks for something while it runs, and sets or uses something itself.
pub(crate) fn ask(activity: &mut Activity, rng: &mut Rng) {
    let (timeline, least, most) = match rng.u8(0..3) {
        0 => {
            let some = rng.i64(0..=3);
            ("mode", some, rng.i64(some..=3))
        }
        1 => ("fuel", rng.i64(20..50), rng.i64(50..=60)),
        _ => ("seats", 0, rng.i64(1..=4)),
    };
    activity.constraints = vec![Constraint { timeline: timeline.into(), min: least, max: most }];
    if rng.bool() {
        activity.impacts = vec![impact("mode", Effect::SetAtStart(rng.i64(0..=3)))];
    }
}

/// A world with ends that matter.
fn stretched(seed: u64) -> World {
    let mut world = world(seed, TINY);
    let mut rng = Rng::with_seed(seed ^ 0xe4d);
    // Energy is to be in the way only seldom.
    world.parameters.soft_min_soc = faregate_planner::units::Ppm::ZERO;
    for activity in &mut world.plan.activities {
        let is_fixed = matches!(activity.kind, Kind::ManualShutdown { .. } | Kind::Cleanup);
        match rng.u8(0..5) {
            _ if is_fixed => {}
            0 | 1 => stretch(activity, &mut rng),
            2 | 3 => ask(activity, &mut rng),
            _ => {}
        }
    }
    world
}

/// By how much all of them together are longer than they must be.
fn longer(world: &World, timed: &TimedPlan) -> i64 {
    let both = world.plan.activities.iter().zip(&timed.rows);
    let over = both.map(|(activity, row)| match row.fate {
        Fate::Scheduled(slot) => slot.length().get() - activity.placed().get(),
        _ => 0,
    });
    over.sum()
}

#[test]
fn an_activity_is_made_longer_up_to_the_first_end_that_is_refused() {
    let (mut wrong, mut expanded) = (Vec::new(), 0);
    let count = seeds(1_500);
    for seed in 0..count {
        let world = stretched(seed);
        let World { plan, parameters, state } = &world;
        let Ok(problem) = Problem::new(plan, parameters, state) else { continue };
        let (fast, slow) = (schedule(&problem, None), reference(plan, parameters, state, None));
        expanded += usize::from(longer(&world, &slow) > 0);
        if bare(&fast) != bare(&slow) {
            println!("seed {seed}: {}", difference(&world, None, &fast, &slow));
            if wrong.is_empty() {
                println!("{}", told(&world, &slow));
            }
            wrong.push(seed);
        }
    }
    println!("{expanded} of {count} plans have something that was made longer");
    assert!(expanded as u64 * 2 > count, "{expanded}");
    assert_eq!(wrong, [0; 0]);
}
