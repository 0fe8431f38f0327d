//! Checks what the planner answers, and what became of it, against the rules:
//! with no line of the planner's but its data types.
//!
//! Everything that the planner generates is derived here once more, from the
//! rules, in the simplest way that is right: anew for each question, and the
//! charge by adding up. Where the two disagree, one of them is wrong, and
//! somebody gets to know.
//!
//! - [`check`]: a timed plan keeps every rule;
//! - [`reference()`]: the same plan again, by trying every millisecond, in small
//!   worlds;
//! - [`naive`] and [`optimum`]: what a plan is worth beside others;
//! - [`check_trace`]: an execution kept every rule, in truth and not by estimate.

#![forbid(unsafe_code)]

mod brute;
mod candidates;
mod computer;
mod computer_rules;
mod execution;
mod flow;
mod given;
mod heating;
mod kept;
mod lines;
mod needs;
mod peers;
mod scene;
mod shared;
mod sleep;
mod steps;
mod times;
mod turns;
mod unavoidable;
mod valid;
mod violation;
mod world;

use faregate_planner::{Parameters, Plan, State, TimedPlan};

pub use brute::reference;
pub use execution::check_trace;
pub use peers::{naive, optimum};
pub use violation::{Rule, Violation};

/// How hard to look for a start in a sleep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Into how many parts each stretch of possible starts is divided, beside
    /// all instants at which something changes; 0: nothing is looked for.
    pub grid: u32,
}

impl Default for Effort {
    fn default() -> Self {
        Self { grid: 16 }
    }
}

/// What is wrong with a timed plan: nothing, if the planner is right.
///
/// `incumbent` is the plan that was being executed when this one was made.
///
/// # Timing
///
/// Slow on purpose: for each activity that is left out, everything is derived
/// anew for each start that is tried.
#[must_use]
pub fn check(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
    timed: &TimedPlan,
    effort: Effort,
) -> Vec<Violation> {
    let scene = scene::Scene::new(plan, parameters, state, incumbent);
    let mut all = given::rows(&scene, timed);
    if !all.is_empty() {
        return all;
    }
    let given = given::Given::new(&scene, timed);
    all.extend(times::check(&given));
    all.extend(shared::check(&given));
    all.extend(shared::excess(&given));
    all.extend(unavoidable::check(&given));
    all.extend(computer_rules::check(&given));
    all.extend(sleep::reasons(&given));
    if effort.grid > 0 {
        all.extend(sleep::check(&given, effort));
    }
    all.sort_by_key(|violation| (violation.at, violation.rule));
    all
}

/// What is wrong with the plan of one pass, beside what [`check`] finds: each
/// activity was valid at its turn, and what mandatory ones exceed is listed just
/// so.
#[must_use]
pub fn check_turns(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
    timed: &TimedPlan,
) -> Vec<Violation> {
    let scene = scene::Scene::new(plan, parameters, state, incumbent);
    let wrong = given::rows(&scene, timed);
    if wrong.is_empty() { turns::check(&given::Given::new(&scene, timed)) } else { wrong }
}
