//! A manual shutdown that now is in, and that does something to named
//! timelines: what it did at its begin is in the state, and comes only once.

use faregate_checker::reference;
use faregate_planner::plan::{Effect, Kind, StartRange};
use faregate_planner::units::Span;
use faregate_planner::{Activity, Problem, project, schedule};
use fastrand::Rng;

use crate::brute::{seeds, told};
use crate::expanding::{ask, impact};
use crate::planner::{bare, difference};
use crate::worlds::{TINY, World, id, world};

/// A shutdown that has begun and is not over.
fn begun(world: &World, rng: &mut Rng) -> Activity {
    let now = world.state.now;
    let from = now.before(Span::new(rng.i64(1..10)));
    let cutoff = now.after(Span::new(rng.i64(2..25)));
    let mut block = Activity::new(id(world.plan.activities.len() + 1), cutoff.since(from));
    block.kind = Kind::ManualShutdown { shutdown: Span::new(1), wakeup: Span::new(1) };
    block.starts = vec![StartRange { from, to: from, cutoff }];
    block.impacts = vec![
        impact("mode", Effect::SetAtStart(rng.i64(0..=3))),
        impact("mode", Effect::SetAtEnd(rng.i64(0..=3))),
        impact("fuel", Effect::AddAtStart(rng.i64(-9..9))),
        impact("fuel", Effect::Rate(rng.i64(-400..400))),
        impact("fuel", Effect::AddAtEnd(rng.i64(-9..9))),
        impact("seats", Effect::Hold(rng.i64(1..=4))),
        impact("bus", Effect::Hold(1)),
    ];
    block.impacts.retain(|_| rng.u8(0..3) > 0);
    block
}

/// A world in which everybody has to do with timelines, and now is in a
/// shutdown.
fn in_a_shutdown(seed: u64) -> World {
    let mut world = world(seed, TINY);
    let mut rng = Rng::with_seed(seed ^ 0xb10c);
    let is_manual = |one: &Activity| matches!(one.kind, Kind::ManualShutdown { .. });
    world.plan.activities.retain(|activity| !is_manual(activity));
    (world.state.windows, world.state.running) = (Vec::new(), Vec::new());
    for activity in &mut world.plan.activities {
        if rng.bool() {
            ask(activity, &mut rng);
            activity.impacts.push(impact("fuel", Effect::AddAtStart(rng.i64(-20..10))));
        } else if rng.bool() {
            activity.impacts = vec![impact("seats", Effect::Hold(rng.i64(1..=4)))];
        }
    }
    let block = begun(&world, &mut rng);
    world.plan.activities.push(block);
    if rng.bool() {
        let values = [("mode", 0..=3), ("fuel", 10..=50), ("seats", 1..=4)];
        let values = values.map(|(name, range)| (name.to_owned(), rng.i64(range)));
        world.state.timelines.extend(values);
    }
    world
}

#[test]
fn what_a_shutdown_did_at_its_begin_comes_only_once() {
    let (mut wrong, mut named) = (Vec::new(), 0);
    let count = seeds(800);
    for seed in 0..count {
        let world = in_a_shutdown(seed);
        let World { plan, parameters, state } = &world;
        let problem = Problem::new(plan, parameters, state).expect("it fits together");
        let (fast, slow) = (schedule(&problem, None), reference(plan, parameters, state, None));
        if bare(&fast) != bare(&slow) {
            println!("seed {seed}: {}", difference(&world, None, &fast, &slow));
            if wrong.is_empty() {
                println!("{}", told(&world, &slow));
            }
            wrong.push(seed);
        }
        named += usize::from(format!("{:?}", fast.rows).contains("Timeline("));
        // What is shown of now is what the state says of it.
        let lines = project(plan, parameters, state, &fast).expect("its names are known").lines;
        for (name, value) in &state.timelines {
            let line = lines.iter().find(|line| line.name == *name).expect("it is shown");
            let starts_now = |r: &faregate_planner::timed::Row| {
                fast.slot(r.id).is_some_and(|slot| slot.start == state.now)
            };
            if !fast.rows.iter().any(starts_now) {
                assert_eq!(line.points[0], (state.now, *value), "seed {seed}: {name}");
            }
        }
    }
    println!("in {named} of {count} plans a named timeline keeps something out");
    assert!(named > 20, "{named}");
    assert_eq!(wrong, [0; 0]);
}
