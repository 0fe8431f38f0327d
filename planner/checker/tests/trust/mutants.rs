//! Broken planners: for each rule one that breaks just that, and is caught.
//!
//! A planner with a limit one off answers as a right one would that was asked
//! about another world: so the world is changed, the planner asked, and its
//! answer held against the world as it was. What no question can bring about is
//! done to the answer.

mod changes;
mod executed;
mod generated;
mod places;
mod told;

use faregate_checker::{Effort, Rule, Violation, check};
use faregate_planner::timed::TimedPlan;
use faregate_planner::{Problem, schedule};

use crate::executions;
use crate::worlds::{TINY, World, world};

/// What is broken about the planner.
#[derive(Clone, Copy)]
pub(crate) enum Mutant {
    /// It takes the world for another one.
    Asked(fn(&mut World)),
    /// It says something else than it should.
    Answered(fn(&World, &mut TimedPlan)),
    /// It forgets the plan that is being executed.
    Forgetful,
    /// The control thread does, or records, something else than it should.
    Executed(executions::Change),
}

use Mutant::{Answered, Asked, Executed, Forgetful};

/// A rule, and a mutant that it catches.
type Entry = (Rule, &'static str, Mutant);

/// All of them.
fn mutants() -> impl Iterator<Item = &'static Entry> {
    [places::MUTANTS, generated::MUTANTS, told::MUTANTS, executed::MUTANTS].into_iter().flatten()
}

/// The planner as it is.
const UNCHANGED: Mutant = Asked(|_| {});

/// So many worlds are tried for each.
const WORLDS: u64 = 6_000;

#[test]
fn every_rule_has_a_mutant() {
    let without: Vec<&Rule> =
        Rule::ALL.iter().filter(|rule| !mutants().any(|(of, ..)| of == *rule)).collect();
    assert_eq!(without, [&Rule::Rows; 0]);
}

#[test]
fn every_mutant_is_caught_by_its_rule() {
    let mut missed = Vec::new();
    for (rule, name, mutant) in mutants() {
        let caught = (0..WORLDS).find(|seed| {
            let found = answers(*seed, *mutant, *rule);
            // A planner that breaks the rule by itself proves nothing.
            let breaks = |found: &[Violation]| found.iter().any(|v| v.rule == *rule);
            breaks(&found) && !breaks(&answers(*seed, UNCHANGED, *rule))
        });
        match caught {
            Some(seed) => println!("{rule:?}: \"{name}\" is caught in world {seed}"),
            None => missed.push((rule, name)),
        }
    }
    assert!(missed.is_empty(), "not caught in {WORLDS} worlds: {missed:?}");
}

/// What the checker says of a mutant's answer.
fn answers(seed: u64, mutant: Mutant, rule: Rule) -> Vec<Violation> {
    let world = world(seed, TINY);
    let grid = if rule == Rule::Sleep { 200 } else { 0 };
    let checked = |timed: &TimedPlan, incumbent: Option<&TimedPlan>| {
        let World { plan, parameters, state } = &world;
        check(plan, parameters, state, incumbent, timed, Effort { grid })
    };
    match mutant {
        Asked(change) => {
            let mut other = world.clone();
            change(&mut other);
            planned(&other).map_or_else(Vec::new, |timed| checked(&timed, None))
        }
        Answered(change) => {
            let Some(mut timed) = planned(&world) else { return Vec::new() };
            change(&world, &mut timed);
            checked(&timed, None)
        }
        Forgetful => {
            let mut poorer = world.clone();
            changes::each(&mut poorer, |activity| activity.duration = activity.placed());
            let plans = planned(&world).zip(planned(&poorer));
            plans.map_or_else(Vec::new, |(timed, incumbent)| checked(&timed, Some(&incumbent)))
        }
        Executed(change) => executions::changed(seed, change),
    }
}

/// What the planner answers; nothing where the world makes no sense.
fn planned(world: &World) -> Option<TimedPlan> {
    let problem = Problem::new(&world.plan, &world.parameters, &world.state).ok()?;
    Some(schedule(&problem, None))
}
