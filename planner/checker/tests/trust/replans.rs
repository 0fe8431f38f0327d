//! Planning again while a plan is being executed, against trying every start and
//! against every rule.

use faregate_checker::{Effort, check, reference};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::{Budget, Problem, improve, schedule, schedule_in_order};

use crate::brute::{seeds, told};
use crate::planner::{bare, difference};
use crate::worlds::{DAY, SOL, Scale, TINY, World, later, world};

/// A world in which a plan is being executed, and that plan.
struct Case {
    world: World,
    problem: Problem,
    incumbent: TimedPlan,
}

/// The case of a seed: up to two times planned again already.
fn case(seed: u64, scale: Scale) -> Case {
    let mut world = world(seed, scale);
    // An improved plan is one that a pass may come to less than.
    let budget = Budget { evaluations: if seed.is_multiple_of(4) { 0 } else { 600 }, seed };
    let mut incumbent = improve(&problem(&world, seed), None, budget, &mut || false).timed;
    for turn in 0..=seed % 3 {
        world = later(&world, &incumbent, seed * 3 + turn);
        if turn < seed % 3 {
            incumbent = schedule(&problem(&world, seed), Some(&incumbent));
        }
    }
    Case { problem: problem(&world, seed), world, incumbent }
}

fn problem(world: &World, seed: u64) -> Problem {
    Problem::new(&world.plan, &world.parameters, &world.state)
        .unwrap_or_else(|unfit| panic!("seed {seed}: {unfit:?}"))
}

/// What of the incumbent is within the commit window.
fn committed(case: &Case) -> usize {
    let now = case.world.state.now;
    let window = now..now.after(case.world.parameters.commit);
    let slots = case.incumbent.rows.iter().filter_map(|row| match row.fate {
        Fate::Scheduled(slot) => Some(slot.start),
        _ => None,
    });
    slots.filter(|start| window.contains(start)).count()
}

#[test]
fn planning_again_answers_what_trying_every_start_answers() {
    let (mut wrong, mut commits, mut kept, mut forgetful) = (Vec::new(), 0, 0, 0);
    let count = seeds(1_000);
    let only = std::env::var("SEED").ok().and_then(|seed| seed.parse::<u64>().ok());
    for seed in (0..count).filter(|seed| only.is_none_or(|only| only == *seed)) {
        let case = case(seed, TINY);
        let World { plan, parameters, state } = &case.world;
        let slow = reference(plan, parameters, state, Some(&case.incumbent));
        let fast = schedule(&case.problem, Some(&case.incumbent));
        if bare(&fast) != bare(&slow) {
            println!(
                "seed {seed}: {}",
                difference(&case.world, Some(&case.incumbent), &fast, &slow)
            );
            if only.is_some() {
                println!("{}", told(&case.world, &slow));
            }
            wrong.push(seed);
        }
        commits += u64::from(committed(&case) > 0);
        let pass = schedule_in_order(&case.problem, case.problem.order(), Some(&case.incumbent)).0;
        kept += usize::from(pass != fast);
        // A planner that forgets what is being executed does not pass for this one.
        let anew = schedule(&case.problem, None);
        forgetful += u64::from(bare(&anew) != bare(&slow));
    }
    println!(
        "{count} plans made again: {commits} with something in the commit window, {kept} kept"
    );
    println!("the incumbent makes a difference in {forgetful}");
    assert_eq!(wrong, [0; 0]);
    assert!(commits * 10 > count && kept > 2, "{commits} {kept}");
    assert!(forgetful * 10 > count, "{forgetful}");
}

#[test]
fn days_planned_again_keep_every_rule() {
    let mut commits = 0;
    for (scale, count) in [(DAY, seeds(60)), (SOL, seeds(60))] {
        for seed in 0..count {
            let case = case(seed, scale);
            let World { plan, parameters, state } = &case.world;
            let timed = schedule(&case.problem, Some(&case.incumbent));
            let effort = Effort { grid: 4 };
            let wrong = check(plan, parameters, state, Some(&case.incumbent), &timed, effort);
            assert_eq!(wrong, [], "seed {seed}: {}", told(&case.world, &timed));
            commits += u64::from(committed(&case) > 0);
        }
    }
    assert!(commits > 20, "{commits}");
}
