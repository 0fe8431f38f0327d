//! Improvement with the time that is left: bounded repair that can be stopped
//! at any moment, and never answers anything worse.
//!
//! The pass takes candidates in an order, and each at its earliest start. Both
//! can be otherwise: who comes when, and where each [leans](Leaning) to. A round
//! moves something that was left out before what may be in its way, or something
//! that is in behind others, or has something start elsewhere, and runs the pass
//! again. It is given up when it has left out more than the one that it was made
//! from; one that comes to less all the same is forgotten, but for some by
//! chance.

use crate::draws::Draws;
use crate::problem::Problem;
use crate::timed::TimedPlan;

use super::lean::Leaning;
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
/// plan. A pass is never cut short that makes the first plan, or one that is
/// known to be better.
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
    while search.found.turns.order.len() > 1 && search.round(stop) {}
    search.best
}

/// What a pass is run with.
#[derive(Clone, Debug)]
struct Turns {
    /// Who comes when, of those that are still open.
    order: Vec<usize>,
    /// Where each activity leans to.
    leanings: Vec<Leaning>,
}

/// What a pass came to.
#[derive(Clone, Debug)]
struct Found {
    turns: Turns,
    worth: Worth,
    left_out: Vec<usize>,
}

/// A search, between two rounds.
struct Search<'a> {
    /// What is decided before anybody's turn.
    begun: Pass<'a>,
    budget: Budget,
    draws: Draws,
    best: Improved,
    /// What the next round is made from.
    from: Found,
    /// The best that a pass came to.
    found: Found,
    /// Rounds since there was a better one.
    idle: u32,
}

/// After so many rounds in vain the search goes on from the best one.
const PATIENCE: u32 = 60;
/// So many rounds in a hundred may come to less than what they are made from.
const DETOURS: usize = 20;
/// To so much less: this part of the value.
const DETOUR: u128 = 50;
/// So many things are otherwise in a round, at most.
const MOVES: usize = 6;
/// So many of a hundred of them are about where an activity leans to, the others
/// about when it has its turn.
const LEANINGS: usize = 75;

impl<'a> Search<'a> {
    fn new(problem: &'a Problem, incumbent: Option<&'a TimedPlan>, budget: Budget) -> Self {
        let begun = Pass::new(problem, incumbent);
        let order = problem.order().iter().copied().filter(|&item| begun.is_open(item)).collect();
        let turns = Turns { order, leanings: begun.leanings.clone() };
        let pass = begun.clone().with(&turns);
        let timed = pass.answer();
        let found = Found::of(turns, &pass);
        let (worth, evaluations) = (found.worth.clone(), pass.effort.candidates);
        let best = Improved { timed, worth, evaluations, rounds: 1 };
        Self {
            begun,
            budget,
            draws: Draws::new(budget.seed),
            best,
            from: found.clone(),
            found,
            idle: 0,
        }
    }

    /// What the incumbent has, at its times, as far as that still fits.
    fn keep(&mut self, incumbent: &TimedPlan) {
        let pass = super::keep::keep(self.begun.problem, incumbent);
        self.best.evaluations += pass.effort.candidates;
        let timed = pass.answer();
        let worth = Worth::of(pass.problem, &timed);
        if worth > self.best.worth {
            (self.best.timed, self.best.worth) = (timed, worth);
        }
    }

    /// Other turns. Whether there may be a further round.
    fn round(&mut self, stop: &mut dyn FnMut() -> bool) -> bool {
        let turns = self.neighbour();
        let detour = self.draws.percent(DETOURS);
        let less = if detour { self.from.worth.optional() / DETOUR } else { 0 };
        let mut to_lose = self.begun.value_of(&self.from.left_out) + less;
        let mut pass = self.begun.clone();
        pass.leanings.clone_from(&turns.leanings);
        pass.says_why = false;
        let left = self.budget.evaluations.saturating_sub(self.best.evaluations);
        for &item in &turns.order {
            if pass.effort.candidates >= left || stop() {
                self.best.evaluations += pass.effort.candidates;
                return false;
            }
            pass.turn(item);
            let lost = if pass.is_open(item) { pass.value_of(&[item]) } else { 0 };
            let Some(rest) = to_lose.checked_sub(lost) else {
                self.best.evaluations += pass.effort.candidates;
                self.in_vain();
                return true;
            };
            to_lose = rest;
        }
        pass.look_again(&turns.order);
        pass.finish(&turns.order);
        self.best.evaluations += pass.effort.candidates;
        self.best.rounds += 1;
        self.accept(Found::of(turns, &pass), less);
        true
    }

    /// Goes on from what is worth as much as the last one, or by no more than so
    /// much less.
    fn accept(&mut self, new: Found, less: u128) {
        if new.worth > self.best.worth {
            self.best.timed = self.begun.clone().with(&new.turns).answer();
            self.best.worth = new.worth.clone();
        }
        if new.worth > self.found.worth {
            self.found = new.clone();
            self.idle = 0;
            self.from = new;
            return;
        }
        if new.worth.comes_near(&self.from.worth, less) {
            self.from = new;
        }
        self.in_vain();
    }

    fn in_vain(&mut self) {
        self.idle += 1;
        if self.idle.is_multiple_of(PATIENCE) {
            self.from = self.found.clone();
        }
    }

    /// The turns with some things otherwise.
    fn neighbour(&mut self) -> Turns {
        let mut turns = self.from.turns.clone();
        for _ in 0..=self.draws.below(MOVES) {
            if self.draws.percent(LEANINGS) {
                self.lean(&mut turns);
            } else {
                self.reorder(&mut turns.order);
            }
        }
        // An optional one that comes first would leave mandatory ones to break
        // the handover minimum that it was not to break itself.
        turns.order.sort_by_key(|&item| !self.begun.problem.items[item].mandatory);
        turns
    }

    /// One of them leans elsewhere.
    fn lean(&mut self, turns: &mut Turns) {
        let item = turns.order[self.draws.below(turns.order.len())];
        let ranges = &self.begun.problem.items[item].ranges;
        turns.leanings[item] =
            match (self.draws.below(4), ranges.get(self.draws.below(ranges.len()))) {
                (0 | 1, Some(range)) => {
                    Leaning::NotBefore(self.draws.between(range.from, range.to))
                }
                (2, _) => Leaning::Awake,
                _ => Leaning::Earliest,
            };
    }

    /// One of them has its turn at another place.
    fn reorder(&mut self, order: &mut Vec<usize>) {
        let (count, out) = (order.len(), self.from.left_out.len());
        let (from, to) = if out > 0 && self.draws.percent(60) {
            // One that was left out, somewhere before.
            let item = self.from.left_out[self.draws.below(out)];
            let from = order.iter().position(|&other| other == item).unwrap_or(0);
            (from, self.draws.below(from + 1))
        } else {
            (self.draws.below(count), self.draws.below(count))
        };
        let item = order.remove(from);
        order.insert(to, item);
    }
}

impl Found {
    fn of(turns: Turns, pass: &Pass<'_>) -> Self {
        let left_out = turns.order.iter().copied().filter(|&item| pass.is_open(item)).collect();
        Self { worth: Worth::of(pass.problem, &pass.answer()), turns, left_out }
    }
}

impl Pass<'_> {
    /// Whether it is to be decided, and is not in.
    fn is_open(&self, item: usize) -> bool {
        self.slots[item].is_none() && self.problem.items[item].is_candidate()
    }

    /// What the optional ones of them are worth together.
    fn value_of(&self, items: &[usize]) -> u128 {
        let optional = items.iter().filter(|&&item| !self.problem.items[item].mandatory);
        optional.map(|&item| u128::from(self.problem.plan.activities[item].worth())).sum()
    }

    /// The whole pass.
    fn with(mut self, turns: &Turns) -> Self {
        self.leanings.clone_from(&turns.leanings);
        self.run(&turns.order)
    }
}
