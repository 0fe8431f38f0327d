//! What holds between plans: equal ones, improved ones, ones with more slack.

use faregate_checker::{Effort, check};
use faregate_planner::schedule::{Budget, Worth, improve};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::units::{Bytes, Ppm, Span};
use faregate_planner::{ActivityId, Problem};
use faregate_tickets::amount::Milliwatts;

use crate::brute::{seeds, told};
use crate::planner::planned;
use crate::worlds::{TINY, World, world};

fn problem(world: &World) -> Problem {
    let World { plan, parameters, state } = world;
    Problem::new(plan, parameters, state).expect("it fits together")
}

fn bytes(timed: &TimedPlan) -> Vec<u8> {
    postcard::to_stdvec(timed).expect("it has a serial form")
}

#[test]
fn equal_input_gives_equal_bytes() {
    let plans: Vec<Vec<u8>> = (0..seeds(300)).map(|s| bytes(&planned(&world(s, TINY)))).collect();
    for (seed, plan) in (0..).zip(&plans) {
        assert!(*plan == bytes(&planned(&world(seed, TINY))), "seed {seed}");
    }
    let equal = plans.windows(2).filter(|pair| pair[0] == pair[1]).count();
    assert!(equal < plans.len() / 20, "{equal} of {} are like the next", plans.len());
}

/// Nobody depends on it, and nobody would be told that it is in the way.
fn is_alone(world: &World, id: ActivityId) -> bool {
    let mut after = world.plan.activities.iter().flat_map(|activity| &activity.after);
    !after.any(|dependency| dependency.prior == id)
}

#[test]
fn removing_what_is_left_out_changes_nothing_but_its_row() {
    let mut removed = 0;
    for seed in 0..seeds(400) {
        let whole = world(seed, TINY);
        let timed = planned(&whole);
        let left_out = timed.rows.iter().filter(|row| matches!(row.fate, Fate::Out(_)));
        let Some(row) = left_out.into_iter().find(|row| is_alone(&whole, row.id)) else { continue };
        let mut smaller = whole.clone();
        smaller.plan.activities.retain(|activity| activity.id != row.id);
        let mut expected = timed.clone();
        expected.rows.retain(|other| other.id != row.id);
        let found = planned(&smaller);
        assert!(
            found == expected,
            "seed {seed}: {}\n{}",
            told(&whole, &timed),
            told(&smaller, &found)
        );
        removed += 1;
    }
    assert!(removed > 100, "{removed}");
}

#[test]
fn what_is_improved_is_never_worth_less_and_keeps_every_rule() {
    let (mut better, mut all) = (0, 0);
    for seed in 0..seeds(200) {
        let world = world(seed, TINY);
        let World { plan, parameters, state } = &world;
        let (problem, timed) = (problem(&world), planned(&world));
        let budget = Budget { evaluations: 300, seed };
        let improved = improve(&problem, None, budget, &mut || false);
        let (before, after) = (Worth::of(&problem, &timed), Worth::of(&problem, &improved.timed));
        assert!(after >= before, "seed {seed}: {before:?} {after:?}");
        assert_eq!(after, improved.worth, "seed {seed}");
        let effort = Effort { grid: 8 };
        let wrong = check(plan, parameters, state, None, &improved.timed, effort);
        assert_eq!(wrong, [], "seed {seed}: {}", told(&world, &improved.timed));
        (better, all) = (better + usize::from(after > before), all + 1);
    }
    println!("{better} of {all} plans were improved");
    assert!(better > all / 50, "{better} of {all}");
}

#[test]
fn with_more_slack_and_the_old_plan_nothing_is_worth_less() {
    let more: [fn(&mut World); 5] = [
        |world| {
            let limit = &mut world.parameters.peak_limit;
            *limit = limit.saturating_add(Milliwatts::from_watts(40));
        },
        |world| {
            world.plan.max_delta_data = Bytes::new(world.plan.max_delta_data.get() + 50);
        },
        |world| {
            world.parameters.soft_min_soc = Ppm::new(world.parameters.soft_min_soc.get() / 2);
        },
        |world| world.parameters.engines += 1,
        |world| {
            for activity in &mut world.plan.activities {
                for range in &mut activity.starts {
                    range.to = range.to.after(Span::new(10));
                    range.cutoff = range.cutoff.after(Span::new(20));
                }
            }
        },
    ];
    let mut better = 0;
    for seed in 0..seeds(150) {
        let world = world(seed, TINY);
        let timed = planned(&world);
        for (which, change) in more.iter().enumerate() {
            let mut slack = world.clone();
            change(&mut slack);
            let problem = problem(&slack);
            let budget = Budget { evaluations: 100, seed };
            let improved = improve(&problem, Some(&timed), budget, &mut || false);
            let (before, after) =
                (Worth::of(&problem, &timed), Worth::of(&problem, &improved.timed));
            assert!(
                after >= before,
                "seed {seed}, slack {which}: {before:?} {after:?}: {}",
                told(&world, &timed)
            );
            better += usize::from(after > before);
        }
    }
    println!("{better} times it was worth more");
    assert!(better > 50, "{better}");
}
