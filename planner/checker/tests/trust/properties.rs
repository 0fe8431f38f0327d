//! What holds between plans: equal ones, improved ones, ones with more slack.
//!
//! Each is asked of the planner, and of planners that are broken just so.

mod broken;
mod slack;

use std::collections::BTreeSet;

use faregate_checker::{Effort, check};
use faregate_planner::schedule::{Budget, Improved, Worth, improve, schedule};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::{ActivityId, Problem};

use crate::brute::{seeds, told};
use crate::worlds::{TINY, World, world};

/// A planner: right, or broken.
#[derive(Clone, Copy)]
struct Planner {
    schedule: fn(&Problem, Option<&TimedPlan>) -> TimedPlan,
    improve: fn(&Problem, Option<&TimedPlan>, Budget) -> Improved,
}

/// The planner.
const RIGHT: Planner = Planner {
    schedule,
    improve: |problem, old, budget| improve(problem, old, budget, &mut || false),
};

/// What a property says of a seed: whether it had anything to say, or how it
/// does not hold.
type Said = Result<usize, String>;

/// It holds of the planner for so many seeds, and says something so often in a
/// hundred of them, at least.
fn holds(property: fn(u64, Planner) -> Said, count: u64, percent: u64) {
    let mut said = 0;
    for seed in 0..count {
        said += property(seed, RIGHT).unwrap_or_else(|how| panic!("seed {seed}: {how}"));
    }
    println!("{said} cases in {count} plans");
    assert!(said as u64 * 100 >= count * percent, "{said} cases in {count} plans");
}

/// It does not hold of a broken planner.
fn catches(property: fn(u64, Planner) -> Said, broken: Planner) {
    let caught = (0..1_000).find(|seed| property(*seed, broken).is_err());
    println!("caught in {caught:?}");
    assert!(caught.is_some(), "a broken planner passes");
}

fn problem(world: &World) -> Problem {
    let World { plan, parameters, state } = world;
    Problem::new(plan, parameters, state).expect("it fits together")
}

fn bytes(timed: &TimedPlan) -> Vec<u8> {
    postcard::to_stdvec(timed).expect("it has a serial form")
}

/// Equal input gives equal bytes.
fn is_repeatable(seed: u64, planner: Planner) -> Said {
    let world = world(seed, TINY);
    let budget = Budget { evaluations: 60, seed };
    let answers = || {
        let problem = problem(&world);
        let timed = (planner.schedule)(&problem, None);
        let improved = (planner.improve)(&problem, Some(&timed), budget);
        [bytes(&timed), bytes(&improved.timed)]
    };
    if answers() == answers() { Ok(1) } else { Err("the second answer differs".into()) }
}

#[test]
fn equal_input_gives_equal_bytes() {
    holds(is_repeatable, seeds(1_000), 100);
    catches(is_repeatable, broken::MOODY);
}

#[test]
fn plans_differ() {
    let plans: BTreeSet<Vec<u8>> =
        (0..300).map(|seed| bytes(&schedule(&problem(&world(seed, TINY)), None))).collect();
    assert!(plans.len() > 285, "only {} of 300 are unlike the others", plans.len());
}

/// Nobody depends on it, and nobody would be told that it is in the way.
fn is_alone(world: &World, id: ActivityId) -> bool {
    let mut after = world.plan.activities.iter().flat_map(|activity| &activity.after);
    !after.any(|dependency| dependency.prior == id)
}

/// To remove something that is left out changes nothing but its row.
fn ignores_what_is_out(seed: u64, planner: Planner) -> Said {
    let whole = world(seed, TINY);
    let timed = (planner.schedule)(&problem(&whole), None);
    let mut removed = 0;
    for row in timed.rows.iter().filter(|row| matches!(row.fate, Fate::Out(_))) {
        if !is_alone(&whole, row.id) {
            continue;
        }
        let mut smaller = whole.clone();
        smaller.plan.activities.retain(|activity| activity.id != row.id);
        let mut expected = timed.clone();
        expected.rows.retain(|other| other.id != row.id);
        let found = (planner.schedule)(&problem(&smaller), None);
        if found != expected {
            return Err(format!("{}\n{}", told(&whole, &timed), told(&smaller, &found)));
        }
        removed += 1;
    }
    Ok(removed)
}

#[test]
fn removing_what_is_left_out_changes_nothing_but_its_row() {
    holds(ignores_what_is_out, seeds(1_000), 100);
    catches(ignores_what_is_out, broken::COUNTING);
}

/// What is improved is never worth less than the pass or the incumbent, and
/// keeps every rule. Says whether it is worth more.
fn never_gets_worse(seed: u64, planner: Planner) -> Said {
    let world = world(seed, TINY);
    let World { plan, parameters, state } = &world;
    let problem = problem(&world);
    let timed = (planner.schedule)(&problem, None);
    let budget = Budget { evaluations: 300, seed };
    let improved = (planner.improve)(&problem, None, budget);
    let worth = |timed: &TimedPlan| Worth::of(&problem, timed);
    let (before, after) = (worth(&timed), worth(&improved.timed));
    if after < before || after != improved.worth {
        return Err(format!("{before:?} {after:?}"));
    }
    let wrong = check(plan, parameters, state, None, &improved.timed, Effort { grid: 8 });
    if !wrong.is_empty() {
        return Err(format!("{wrong:?}: {}", told(&world, &improved.timed)));
    }
    // Without a single evaluation to spare it still has what it was given.
    let budget = Budget { evaluations: 0, seed };
    let kept = worth(&(planner.improve)(&problem, Some(&improved.timed), budget).timed);
    let again = worth(&(planner.schedule)(&problem, Some(&improved.timed)));
    if kept < after || again < after {
        let told = told(&world, &improved.timed);
        return Err(format!("of {after:?} it keeps {kept:?} and {again:?}: {told}"));
    }
    Ok(usize::from(after > before))
}

#[test]
fn what_is_improved_is_never_worth_less_and_keeps_every_rule() {
    holds(never_gets_worse, seeds(400), 5);
    catches(never_gets_worse, broken::CARELESS);
    catches(never_gets_worse, broken::FORGETFUL);
    catches(never_gets_worse, broken::BOASTING);
}

#[test]
fn with_more_slack_and_the_old_plan_nothing_is_worth_less() {
    holds(slack::never_costs, seeds(400), 50);
    catches(slack::never_costs, broken::FORGETFUL);
}

/// Where the plan that is executed starts everything within the commit window,
/// no round tries anybody: it must end all the same.
#[test]
fn improvement_ends_where_everything_is_committed() {
    for seed in 0..seeds(200) {
        let mut world = world(seed, TINY);
        let old = schedule(&problem(&world), None);
        world.parameters.commit = world.plan.end.since(world.state.now);
        let mut asked = 0;
        let mut stop = || {
            asked += 1;
            assert!(asked < 1_000, "seed {seed}: it asks again and again");
            false
        };
        let budget = Budget { evaluations: 100, seed };
        let new = improve(&problem(&world), Some(&old), budget, &mut stop);
        let slots = |timed: &TimedPlan| -> Vec<_> {
            timed.rows.iter().filter_map(|row| timed.slot(row.id).map(|slot| slot.start)).collect()
        };
        assert!(slots(&new.timed).len() >= slots(&old).len(), "seed {seed}: something is lost");
    }
}
