//! The plan that is being executed, kept where a new pass would be worth less.
//!
//! A pass takes candidates in an order, each at its earliest start, so with more
//! room it can come to less: what fits now is in the way of two others. The plan
//! that is there has a start for each activity that is known to have fitted.

mod whole;

use crate::problem::Problem;
use crate::timed::{Fate, Row, Slot, TimedPlan};

use super::{Pass, Worth};
use whole::whole;

/// The better one of a pass's plan and of what the incumbent becomes: never
/// worth less than the incumbent, where everything in it still fits.
///
/// # Timing
///
/// Two comparisons, where the pass's plan is worth no less than the incumbent.
pub(super) fn better_of(problem: &Problem, incumbent: &TimedPlan, timed: TimedPlan) -> TimedPlan {
    let worth = Worth::of(problem, &timed);
    if worth >= Worth::of(problem, &hoped(problem, incumbent, &timed)) {
        return timed;
    }
    let kept = keep(problem, incumbent).answer();
    if Worth::of(problem, &kept) > worth { kept } else { timed }
}

/// What the incumbent becomes: all of it at its times where all of it still
/// fits, or else as much as does; and what fits beside it.
pub(super) fn keep<'a>(problem: &'a Problem, incumbent: &TimedPlan) -> Pass<'a> {
    let begun = Pass::new(problem, Some(incumbent));
    let wanted = wanted(problem, incumbent);
    // What is committed is in already.
    let open = problem.order().iter().filter(|&&item| begun.slots[item].is_none());
    let slots: Vec<(usize, Slot)> = open.filter_map(|&item| Some((item, wanted[item]?))).collect();
    let whole = whole(begun.clone(), &slots, incumbent);
    let mut pass = whole.unwrap_or_else(|| in_turn(begun, &slots));
    pass.look_again(problem.order());
    pass.finish(problem.order());
    pass
}

/// In the order of the pass, again and again: one may only fit when a later one
/// brings it awake time, or when one that expands is as long as it was.
fn in_turn<'a>(mut pass: Pass<'a>, slots: &[(usize, Slot)]) -> Pass<'a> {
    let any = |pass: &mut Pass<'a>, what: fn(&mut Pass<'a>, usize, Slot) -> bool| {
        slots.iter().fold(false, |any, &(item, slot)| what(pass, item, slot) || any)
    };
    loop {
        while any(&mut pass, |pass, item, slot| pass.turn_at(item, slot.start)) {}
        if !any(&mut pass, Pass::lengthens) {
            return pass;
        }
    }
}

impl Pass<'_> {
    /// As long as it was, if it can be. Whether it is longer now.
    fn lengthens(&mut self, item: usize, wanted: Slot) -> bool {
        let Some(slot) = self.slots[item] else { return false };
        let expands = self.problem.items[item].expanding && !self.committed[item];
        if !expands || slot.start != wanted.start || slot.end >= wanted.end {
            return false;
        }
        self.lengthen(item, slot, wanted.end);
        self.slots[item].is_some_and(|now| now.end > slot.end)
    }
}

/// For each activity, when the incumbent has it: only what is still to be
/// decided.
fn wanted(problem: &Problem, incumbent: &TimedPlan) -> Vec<Option<Slot>> {
    let activities = problem.plan.activities.iter().zip(&problem.items);
    let slots: std::collections::BTreeMap<_, _> =
        incumbent.rows.iter().filter_map(|row| Some((row.id, scheduled(row)?))).collect();
    let known = activities.map(|(one, item)| {
        let slot = slots.get(&one.id).filter(|_| item.is_candidate())?;
        (slot.start.get() >= problem.now).then_some(*slot)
    });
    known.collect()
}

const fn scheduled(row: &Row) -> Option<Slot> {
    match row.fate {
        Fate::Scheduled(slot) => Some(slot),
        _ => None,
    }
}

/// The plan that the incumbent would be, if everything in it still fitted.
fn hoped(problem: &Problem, incumbent: &TimedPlan, timed: &TimedPlan) -> TimedPlan {
    let mut hoped = timed.clone();
    let rows = hoped.rows.iter_mut().zip(&problem.items).zip(wanted(problem, incumbent));
    for ((row, item), wanted) in rows {
        if item.is_candidate() {
            let out = Fate::Out(crate::timed::Reason::NoRangeLeft);
            row.fate = wanted.map_or(out, Fate::Scheduled);
        }
    }
    hoped
}
