//! The plan that is being executed, kept where a new pass would be worth less.
//!
//! A pass takes candidates in an order, each at its earliest start, so with more
//! room it can come to less: what fits now is in the way of two others. The plan
//! that is there has a start for each activity that is known to have fitted.

use crate::derive::{Placement, World};
use crate::judge::keeps;
use crate::problem::{Block, Problem, Range};
use crate::timed::{Excess, Fate, Limit, Row, Slot, TimedPlan};
use crate::units::Time;

use super::begin::claim;
use super::{Pass, Worth};

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
    let mut pass = whole(begun.clone(), &slots).unwrap_or_else(|| in_turn(begun, &slots));
    pass.look_again(problem.order());
    pass.finish(problem.order());
    pass
}

/// All at once, if that breaks nothing. One after the other would refuse some:
/// with a part of them alone a sleep may end elsewhere.
fn whole<'a>(mut pass: Pass<'a>, slots: &[(usize, Slot)]) -> Option<Pass<'a>> {
    let base = pass.world.clone();
    for &(item, slot) in slots {
        let range = pass.range(item, slot)?;
        pass.claims[item] = claim(pass.problem, item, slot.length());
        pass.place(item, Slot { range, ..slot });
    }
    let alone = slots.iter().all(|&(item, slot)| pass.fits_beside(item, slot));
    let derived = alone && keeps(pass.problem, (&pass.placed, &pass.world), &base);
    let keeps = derived && pass.keeps_handover(slots, &base);
    keeps.then(|| {
        pass.owns_up(slots, &base);
        pass
    })
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
    /// The first range that admits it, if its group does, too.
    fn range(&self, item: usize, slot: Slot) -> Option<usize> {
        let it = &self.problem.items[item];
        let (start, end) = (slot.start.get(), slot.end.get());
        let from = if it.cleanup { self.problem.now } else { self.from };
        let long = it.shortest..=if it.expanding { it.longest } else { it.shortest };
        let free = self.group(item).is_ok() && from <= start && long.contains(&(end - start));
        let admits = |range: &Range| (range.from..=range.to).contains(&start) && end <= range.last;
        it.ranges.iter().position(admits).filter(|_| free)
    }

    /// Whether its priors are over, and it breaks nothing beside what is placed
    /// of what does not depend on what is derived.
    fn fits_beside(&mut self, item: usize, slot: Slot) -> bool {
        let (start, end) = (slot.start.get(), slot.end.get());
        let after = self.after(item).is_ok_and(|after| after <= start);
        let apart = |block: &Block| end <= block.from || block.to <= start || start == end;
        let claim = &self.claims[item];
        self.timelines.remove(claim, slot.start);
        let fits = !self.timelines.valid_starts(claim, (slot.start, slot.start)).is_empty();
        self.timelines.insert(claim, slot.start);
        after && fits && self.problem.blocks.iter().all(apart)
    }

    /// Whether no optional one breaks the minimum at handover: mandatory ones
    /// may. Either it is not lower than with them alone, or the optional ones
    /// alone keep it, and were placed before.
    fn keeps_handover(&self, slots: &[(usize, Slot)], base: &World) -> bool {
        let Some(at) = self.problem.handover else { return true };
        let (charge, least) = (self.world.charge(at), self.problem.battery.handover);
        let alone = |mandatory: bool| {
            let mut placed = self.placed.clone();
            let is_other = |item: usize| self.problem.items[item].mandatory != mandatory;
            for &(item, slot) in slots.iter().filter(|slot| is_other(slot.0)) {
                let (start, end) = (slot.start.get(), slot.end.get());
                placed.remove(self.problem, Placement { item, start, end });
            }
            World::of(self.problem, &placed).charge(at)
        };
        charge >= least || charge >= alone(true) || alone(false) >= least.min(base.charge(at))
    }

    /// Where optional ones were placed before and keep the minimum at handover, it
    /// is the mandatory ones that exceed it: the last of them says so.
    fn owns_up(&mut self, slots: &[(usize, Slot)], base: &World) {
        let Some(at) = self.problem.handover else { return };
        let (charge, min) = (self.world.charge(at), self.problem.battery.handover);
        let is_mandatory = |slot: &&(usize, Slot)| self.problem.items[slot.0].mandatory;
        let listed = self.excess.iter().any(|one| one.limit == Limit::Handover);
        let exceeds = charge < min && charge < base.charge(at) && !listed;
        if let Some((item, _)) = slots.iter().rev().find(is_mandatory).filter(|_| exceeds) {
            let (by, at) = (Some(self.id(*item)), Time::new(at));
            self.excess.push(Excess { by, limit: Limit::Handover, at, amount: min - charge });
        }
    }

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
