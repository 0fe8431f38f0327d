//! Improvement with the time that is left: bounded repair that can be stopped
//! at any moment, and never answers anything worse.
//!
//! The pass takes candidates in an order and each at its first chance, so the
//! order is all that there is to change. Each round moves something that was
//! left out before what may be in its way, or something that is in behind
//! others, and runs the pass again. A round that is no better than the best
//! one by more than chance is forgotten.

use crate::draws::Draws;
use crate::problem::Problem;
use crate::timed::{Fate, TimedPlan};

use super::{Pass, Worth};

/// How much may be tried, and by which dice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// So many evaluations of a candidate, those of the first pass included. A
    /// pass that has begun when they are used up is given up.
    pub evaluations: u64,
    /// Equal seeds try the same.
    pub seed: u64,
}

/// The best that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Improved {
    /// The timed plan.
    pub timed: TimedPlan,
    /// What it is worth.
    pub worth: Worth,
    /// How many candidates were evaluated.
    pub evaluations: u64,
    /// How many passes were run to their end.
    pub rounds: u64,
}

/// Plans, and then plans better as long as the budget lasts and nobody says
/// stop.
///
/// The answer is never worth less than [`schedule`](super::schedule)'s, nor
/// than the incumbent where everything in that still fits at its time. It
/// depends on the problem, the incumbent and the budget alone, unless it is
/// stopped; then it is one that a smaller budget would have given.
///
/// # Timing
///
/// `stop` is asked before each evaluation of a candidate, once there is a first
/// plan: the one pass is never cut short.
pub fn improve(
    problem: &Problem,
    incumbent: Option<&TimedPlan>,
    budget: Budget,
    stop: &mut dyn FnMut() -> bool,
) -> Improved {
    let mut search = Search::new(problem, incumbent, budget);
    if let Some(incumbent) = incumbent {
        search.keep(incumbent);
    }
    // Nothing can be moved where there is nothing to choose from.
    while search.order.len() > 1 && search.round(stop) {}
    search.best
}

/// A search, between two rounds.
struct Search<'a> {
    problem: &'a Problem,
    incumbent: Option<&'a TimedPlan>,
    budget: Budget,
    draws: Draws,
    best: Improved,
    /// The order of the round that others are made from.
    order: Vec<usize>,
    /// What that one came to.
    worth: Worth,
    /// What it left out.
    left_out: Vec<usize>,
    /// Rounds since there was a better one.
    idle: u32,
    best_order: Vec<usize>,
}

/// After so many rounds in vain the search goes on from the best order.
const PATIENCE: u32 = 60;

impl<'a> Search<'a> {
    fn new(problem: &'a Problem, incumbent: Option<&'a TimedPlan>, budget: Budget) -> Self {
        let order = problem.order().to_vec();
        let (timed, effort) = super::schedule_in_order(problem, &order, incumbent);
        let worth = Worth::of(problem, &timed);
        let left_out = left_out(&order, &timed);
        let evaluations = effort.candidates;
        Self {
            problem,
            incumbent,
            budget,
            draws: Draws::new(budget.seed),
            best: Improved { timed, worth: worth.clone(), evaluations, rounds: 1 },
            best_order: order.clone(),
            order,
            worth,
            left_out,
            idle: 0,
        }
    }

    /// What the incumbent has, at its times, as far as that still fits.
    fn keep(&mut self, incumbent: &TimedPlan) {
        let pass = super::keep::keep(self.problem, incumbent);
        self.best.evaluations += pass.effort.candidates;
        self.consider(pass.answer());
    }

    /// Another order. Whether there may be a further round.
    fn round(&mut self, stop: &mut dyn FnMut() -> bool) -> bool {
        let order = self.neighbour();
        let mut pass = Pass::new(self.problem, self.incumbent);
        let left = self.budget.evaluations.saturating_sub(self.best.evaluations);
        for &item in &order {
            if pass.effort.candidates >= left || stop() {
                self.best.evaluations += pass.effort.candidates;
                return false;
            }
            pass.turn(item);
        }
        pass.look_again(&order);
        pass.finish(&order);
        self.best.evaluations += pass.effort.candidates;
        self.best.rounds += 1;
        self.accept(order, pass.answer());
        true
    }

    /// Goes on from an order that is as good as the last one, or by chance from
    /// one that is not.
    fn accept(&mut self, order: Vec<usize>, timed: TimedPlan) {
        let worth = Worth::of(self.problem, &timed);
        if worth >= self.worth || self.draws.percent(3) {
            self.left_out = left_out(&order, &timed);
            self.order.clone_from(&order);
            self.worth = worth;
        }
        self.idle += 1;
        if self.consider(timed) {
            self.best_order = order;
            self.idle = 0;
        } else if self.idle.is_multiple_of(PATIENCE) {
            self.order.clone_from(&self.best_order);
            self.left_out = left_out(&self.order, &self.best.timed);
            self.worth = self.best.worth.clone();
        }
    }

    /// Keeps it if it is the best so far.
    fn consider(&mut self, timed: TimedPlan) -> bool {
        let worth = Worth::of(self.problem, &timed);
        let better = worth > self.best.worth;
        if better {
            (self.best.timed, self.best.worth) = (timed, worth);
        }
        better
    }

    /// The order with one to three things moved.
    fn neighbour(&mut self) -> Vec<usize> {
        let mut order = self.order.clone();
        for _ in 0..=self.draws.below(3) {
            let count = order.len();
            let out = self.left_out.len();
            let (from, to) = if out > 0 && self.draws.percent(60) {
                // One that was left out, to somewhere before where it was.
                let item = self.left_out[self.draws.below(out)];
                let from = order.iter().position(|&other| other == item).unwrap_or(0);
                (from, self.draws.below(from + 1))
            } else {
                (self.draws.below(count), self.draws.below(count))
            };
            let item = order.remove(from);
            order.insert(to, item);
        }
        // An optional one that comes first would leave mandatory ones to break
        // the handover minimum that it was not to break itself.
        order.sort_by_key(|&item| !self.problem.items[item].mandatory);
        order
    }
}

/// What of the order is not in.
fn left_out(order: &[usize], timed: &TimedPlan) -> Vec<usize> {
    let is_out =
        |item: &usize| matches!(timed.rows.get(*item).map(|row| &row.fate), Some(Fate::Out(_)));
    order.iter().copied().filter(is_out).collect()
}
