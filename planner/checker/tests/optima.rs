//! The exact solver's optima are of the planner's own worlds: each is a plan
//! that keeps every rule, and none is worth more.

use std::collections::BTreeMap;

use faregate_checker::{Effort, check};
use faregate_planner::generate::{Shape, World};
use faregate_planner::timed::{Fate, Reason, Row, Slot, TimedPlan};
use faregate_planner::units::Time;
use faregate_planner::{Activity, ActivityId, Budget, Problem, improve, schedule};
use serde::Deserialize;

/// What `ci/optimum.sh` wrote.
const OPTIMA: &str = include_str!("../../tools/optima.csv");
/// The grid's step, in ms.
const STEP: i64 = 600_000;

#[derive(Deserialize)]
struct Optimum {
    activities: usize,
    seed: u64,
    checksum: u32,
    optimum: u64,
    bound: u64,
    total: u64,
    /// `ID@STEP ID@STEP ..`
    plan: String,
}

fn optima() -> Vec<(Optimum, World)> {
    let rows = csv::Reader::from_reader(OPTIMA.as_bytes()).into_deserialize();
    let optima = rows.map(|row| {
        let optimum: Optimum = row.expect("the script writes such rows");
        let shape = Shape::small(optimum.activities, optimum.seed);
        assert_eq!(shape.checksum(), optimum.checksum, "another world: run ci/optimum.sh");
        (optimum, shape.draw())
    });
    optima.collect()
}

impl Optimum {
    fn starts(&self) -> BTreeMap<ActivityId, Time> {
        let pairs = self.plan.split_whitespace().map(|word| {
            let (id, step) = word.split_once('@').expect("an activity and its start");
            let id = ActivityId::new(id.parse().expect("a number")).expect("not 0");
            (id, Time::new(STEP * step.parse::<i64>().expect("a step")))
        });
        pairs.collect()
    }
}

/// A plan of these starts, for somebody who looks at rows alone.
fn rows(world: &World, starts: &BTreeMap<ActivityId, Time>) -> TimedPlan {
    let row = |one: &Activity| {
        let slot = |&start: &Time| Slot { start, end: start.after(one.duration), range: 0 };
        let fate = starts.get(&one.id).map(slot).map(Fate::Scheduled);
        Row { id: one.id, fate: fate.unwrap_or(Fate::Out(Reason::NoRangeLeft)) }
    };
    let rows = world.plan.activities.iter().map(row).collect();
    TimedPlan { rows, ..TimedPlan::default() }
}

fn problem(World { plan, parameters, state }: &World) -> Problem {
    Problem::new(plan, parameters, state).expect("a drawn world is fit")
}

/// What is in is worth so much.
fn value(world: &World, timed: &TimedPlan) -> u64 {
    let activities = world.plan.activities.iter();
    activities.filter(|one| timed.slot(one.id).is_some()).map(Activity::worth).sum()
}

/// All of it, at these times, with what follows from it; as much of it as fits.
fn kept(world: &World, starts: &BTreeMap<ActivityId, Time>) -> TimedPlan {
    schedule(&problem(world), Some(&rows(world, starts)))
}

#[test]
fn each_optimum_is_a_plan_that_keeps_every_rule() {
    for (optimum, world) in optima() {
        let which = format!("{} activities, seed {}", optimum.activities, optimum.seed);
        let timed = kept(&world, &optimum.starts());
        assert_eq!(value(&world, &timed), optimum.optimum, "{which}");
        let World { plan, parameters, state } = &world;
        let wrong = check(plan, parameters, state, None, &timed, Effort { grid: 0 });
        assert_eq!(wrong, [], "{which}");
    }
}

#[test]
fn no_plan_is_worth_more_than_the_solver_says_is_possible() {
    let (mut proven, mut better, mut exceeding) = (0, 0, 0);
    let optima = optima();
    for (optimum, world) in &optima {
        let which = format!("{} activities, seed {}", optimum.activities, optimum.seed);
        let problem = problem(world);
        let once = schedule(&problem, None);
        let budget = Budget { evaluations: 2_000, seed: optimum.seed };
        let improved = improve(&problem, None, budget, &mut || false).timed;
        for timed in [&once, &improved] {
            // Mandatory activities may exceed limits that the solver's model
            // keeps: such a plan is none of its solutions.
            let keeps = timed.excess.is_empty();
            exceeding += usize::from(!keeps);
            assert!(!keeps || value(world, timed) <= optimum.bound, "{which}");
        }
        assert!(optimum.optimum <= optimum.bound && optimum.bound <= optimum.total, "{which}");
        proven += u32::from(optimum.optimum == optimum.bound);
        better += u32::from(value(world, &once) < optimum.optimum);
    }
    assert!(exceeding * 10 < optima.len(), "{exceeding} plans of {} worlds", optima.len());
    assert!(proven >= 40 && better >= 30, "{proven} are proven, {better} beat the one pass");
}
