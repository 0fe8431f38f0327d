//! The pass in priority order: from activities to a timed plan.
//!
//! Each candidate takes the earliest start that its ranges, what it depends on
//! and every timeline leave, with the heating and the awake time that follow.
//! Then what was left out is looked at again, since what was placed later may
//! have brought awake time; then expanding activities are made longer.

mod answer;
mod begin;
mod expand;
mod improve;
mod keep;
mod lean;
pub(crate) mod place;
mod unavoidable;
mod worth;

pub use improve::{Budget, Improved, improve};
pub use worth::Worth;

use crate::derive::var::{Reach, Var};
use crate::derive::{Blocked, Candidate, Change, Own, Placed, Placement, World};
use crate::judge::Rest;
use crate::problem::Problem;
use crate::search::Effort;
use crate::timed::{Excess, Reason, Slot, TimedPlan};
use crate::timeline::{Claim, Timelines};

use lean::Leaning;

/// Plans.
///
/// With an incumbent, what it starts within the commit window is left alone,
/// and nothing else starts in that time but what cleans up. The answer is never
/// worth less than the incumbent, as [`Worth`] compares them, where everything
/// in that still fits at its time.
///
/// # Timing
///
/// For each candidate, a few derivations of everything that is placed; twice
/// that where the pass comes to less than the incumbent.
#[must_use]
pub fn schedule(problem: &Problem, incumbent: Option<&TimedPlan>) -> TimedPlan {
    let (timed, _) = schedule_in_order(problem, problem.order(), incumbent);
    match incumbent {
        Some(incumbent) => keep::better_of(problem, incumbent, timed),
        None => timed,
    }
}

/// One pass with the candidates in another order, as indices of the plan's
/// activities; those that are not in it are left out. And how much work it was.
#[must_use]
pub fn schedule_in_order(
    problem: &Problem,
    order: &[usize],
    incumbent: Option<&TimedPlan>,
) -> (TimedPlan, Effort) {
    let pass = Pass::new(problem, incumbent).run(order);
    (pass.answer(), pass.effort)
}

/// The same as [`schedule`] without an incumbent, the slow way: nothing that was
/// derived is kept. Each start is judged by a world that is made from now to
/// the end, and so is the world after each placement. To compare with: in time,
/// and to the byte.
#[must_use]
pub fn schedule_plainly(problem: &Problem) -> (TimedPlan, Effort) {
    let mut pass = Pass::new(problem, None);
    pass.plain = true;
    let pass = pass.run(problem.order());
    (pass.answer(), pass.effort)
}

/// What is decided so far.
#[derive(Clone, Debug)]
pub(crate) struct Pass<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) placed: Placed,
    pub(crate) world: World,
    pub(crate) timelines: Timelines,
    /// One for each activity, of the length that it has, or is placed with.
    pub(crate) claims: Vec<Claim>,
    /// When each activity runs: those that run already included.
    pub(crate) slots: Vec<Option<Slot>>,
    reasons: Vec<Option<Reason>>,
    /// Which member has used a group up.
    groups: Vec<Option<usize>>,
    /// What is not to be moved.
    committed: Vec<bool>,
    /// When a candidate can start that does not clean up.
    pub(crate) from: i64,
    excess: Vec<Excess>,
    unavoidable: Vec<Excess>,
    /// Counts placements, and what it was when a candidate failed last: nothing
    /// has changed since where they are equal.
    version: u64,
    failed: Vec<u64>,
    /// Nothing that was derived is kept.
    plain: bool,
    /// Where each activity starts if it can.
    leanings: Vec<Leaning>,
    /// Whether it is worked out what keeps those out that do not fit.
    says_why: bool,
    pub(crate) effort: Effort,
}

impl Pass<'_> {
    pub(crate) const fn rest(&self) -> Rest<'_> {
        let Self { problem, placed, world, plain, .. } = self;
        Rest { problem, placed, world, plain: *plain }
    }

    fn run(mut self, order: &[usize]) -> Self {
        for &item in order {
            self.turn(item);
        }
        self.look_again(order);
        self.finish(order);
        self
    }

    /// Makes longer what can be, and tries again what that may have made room
    /// for: what lasts longer drains more, so that a sleep ends later.
    fn finish(&mut self, order: &[usize]) {
        loop {
            self.expand(order);
            if !self.look_again(order) {
                break;
            }
        }
    }

    /// Tries those that were left out again, until none gets in. Whether one
    /// did.
    fn look_again(&mut self, order: &[usize]) -> bool {
        let begin = self.version;
        loop {
            let before = self.version;
            for &item in order {
                if self.slots[item].is_none() && self.failed[item] != self.version {
                    self.turn(item);
                }
            }
            if self.version == before {
                return before != begin;
            }
        }
    }

    /// Places something for good.
    fn put(&mut self, item: usize, slot: Slot) {
        let (start, end) = (slot.start.get(), slot.end.get());
        let change = self.change(item, slot);
        self.placed.insert(self.problem, Placement { item, start, end });
        self.timelines.insert(&self.claims[item], slot.start);
        self.slots[item] = Some(slot);
        self.reasons[item] = None;
        if let Some(group) = self.problem.items[item].group {
            self.groups[group].get_or_insert(item);
        }
        let world = core::mem::take(&mut self.world);
        self.world = match change {
            Ok(None) => world,
            Ok(Some(change)) if !self.plain => world.after(self.problem, &self.placed, change),
            Ok(Some(_)) | Err(Blocked) => World::of(self.problem, &self.placed),
        };
        self.version += 1;
    }

    /// Between which instants something is otherwise with it placed.
    fn change(&self, item: usize, slot: Slot) -> Result<Option<Change>, Blocked> {
        let (start, end) = (Var::fixed(slot.start.get()), Var::fixed(slot.end.get()));
        let candidate = Candidate { item, start, end };
        let own = Own::of(self.problem, &self.placed, candidate, &mut { Reach::ALL })?;
        Ok(Change::of(&own))
    }
}
