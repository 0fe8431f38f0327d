//! Whole days, thousands of them: no rule is broken, and the plan is worth more
//! than a naive one, and not much less than the best there is.

use faregate_checker::{Effort, Rule, check, naive, optimum};
use faregate_planner::generate::Shape;
use faregate_planner::timed::TimedPlan;

use crate::brute::{seeds, told, wrong};
use crate::planner::planned;
use crate::worlds::{DAY, MICRO, SOL, Scale, World, world};

/// The sum of worths of what is in.
fn value(world: &World, timed: &TimedPlan) -> u64 {
    let activities = world.plan.activities.iter();
    activities.filter(|a| timed.slot(a.id).is_some()).map(faregate_planner::Activity::worth).sum()
}

#[test]
fn days_keep_every_rule_and_are_worth_more_than_naive_ones() {
    beside_naive_ones(DAY, seeds(120));
}

#[test]
fn days_of_full_length_keep_every_rule_and_are_worth_more_than_naive_ones() {
    beside_naive_ones(SOL, seeds(120));
}

fn beside_naive_ones(scale: Scale, count: u64) {
    let (mut ours, mut theirs, mut lower) = (0, 0, 0);
    for seed in 0..count {
        let world = world(seed, scale);
        let timed = planned(&world);
        let wrong = wrong(&world, None, &timed, Effort { grid: 4 });
        assert_eq!(wrong, [""; 0], "seed {seed}: {}", told(&world, &timed));

        let World { plan, parameters, state } = &world;
        let peer = naive(plan, parameters, state, 10 * scale.unit);
        let mut said = check(plan, parameters, state, None, &peer, Effort { grid: 0 });
        // It gives up before it has seen every start, so it cannot say why.
        said.retain(|violation| violation.rule != Rule::Reason);
        assert_eq!(said, [], "the naive one, seed {seed}: {}", told(&world, &peer));
        let (better, worse) = (value(&world, &timed), value(&world, &peer));
        (ours, theirs, lower) = (ours + better, theirs + worse, lower + u64::from(better < worse));
    }
    println!("value {ours} beside {theirs} of the naive planner; lower in {lower} of {count} days");
    assert!(ours > theirs, "{ours} {theirs}");
}

#[test]
fn drawn_sols_keep_every_rule() {
    let mut worlds: Vec<(String, World)> = Vec::new();
    for seed in 0..seeds(40) {
        for (name, shape) in [("sol", Shape::sols(30, seed)), ("small", Shape::small(25, seed))] {
            let faregate_planner::generate::World { plan, parameters, state } = shape.draw();
            worlds.push((format!("{name} {seed}"), World { plan, parameters, state }));
        }
    }
    for (name, world) in worlds {
        let timed = planned(&world);
        let wrong = wrong(&world, None, &timed, Effort { grid: 2 });
        assert_eq!(wrong, [""; 0], "{name}: {}", told(&world, &timed));
    }
}

#[test]
fn small_plans_are_worth_nearly_as_much_as_the_best_there_is() {
    let (mut ours, mut best, mut beaten) = (0, 0, 0);
    let count = seeds(60);
    for seed in 0..count {
        let world = world(seed, MICRO);
        let World { plan, parameters, state } = &world;
        let fixed = |id| state.running.iter().any(|running| running.id == id);
        let manual = |a: &faregate_planner::Activity| {
            matches!(a.kind, faregate_planner::plan::Kind::ManualShutdown { .. })
        };
        let timed = planned(&world);
        let chosen = plan.activities.iter().filter(|a| !fixed(a.id) && !manual(a));
        let value: u64 = chosen
            .filter(|a| timed.slot(a.id).is_some())
            .map(faregate_planner::Activity::worth)
            .sum();
        let most = optimum(plan, parameters, state);
        assert!(value <= most, "seed {seed}: {value} of {most}: {}", told(&world, &timed));
        (ours, best, beaten) = (ours + value, best + most, beaten + u64::from(value < most));
    }
    println!("value {ours} of {best} at best; less than the best in {beaten} of {count} plans");
    assert!(ours * 10 >= best * 9, "{ours} of {best}");
    assert!(beaten > 0, "nothing was left to be desired: the worlds are too easy");
}
