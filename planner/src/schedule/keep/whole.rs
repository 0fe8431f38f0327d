//! Everything that an incumbent has, at once.
//!
//! One after the other would refuse some of it: with a part of it alone a sleep
//! may end elsewhere, and what was placed in another order was compared with
//! other things. So all of it is compared with the world in which nothing of it
//! is placed, as whoever checks a plan does.

use std::collections::BTreeSet;

use crate::derive::{Placement, World};
use crate::judge::keeps;
use crate::problem::{Block, Range};
use crate::schedule::Pass;
use crate::schedule::begin::claim;
use crate::timed::{Excess, Limit, Slot, TimedPlan};
use crate::timeline::Timelines;
use crate::units::Time;

/// What mandatory activities of the incumbent are listed to exceed.
///
/// At its turn an optional activity may have found room at handover, or for its
/// data, that a mandatory one took afterwards. In which order that was, nobody
/// can tell from where they lie; that they exceed it together, and that the
/// optional ones are not to blame, the incumbent says.
#[derive(Clone, Copy, Default)]
struct Exceeded {
    /// By how much the charge at handover is below the minimum, at most.
    handover: i64,
    data: bool,
}

/// The incumbent's slots, if all of them together break nothing.
pub(super) fn whole<'a>(
    mut pass: Pass<'a>,
    slots: &[(usize, Slot)],
    incumbent: &TimedPlan,
) -> Option<Pass<'a>> {
    let (base, lines) = (pass.world.clone(), pass.timelines.clone());
    for &(item, slot) in slots {
        let range = pass.range(item, slot)?;
        pass.claims[item] = claim(pass.problem, item, slot.length());
        pass.place(item, Slot { range, ..slot });
    }
    let exceeded = pass.exceeded(incumbent);
    let alone = slots.iter().all(|&(item, slot)| pass.fits_beside(item, slot));
    let keeps = alone
        && pass.keeps_data(slots, exceeded.data)
        && keeps(pass.problem, (&pass.placed, &pass.world), &base)
        && pass.keeps_handover(slots, &base, exceeded.handover);
    keeps.then(|| {
        pass.owns_up(&base, &lines);
        pass
    })
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

    /// The mandatory activities that were decided on, in order: what is
    /// committed included.
    fn mandatory(&self) -> impl DoubleEndedIterator<Item = (usize, Slot)> + Clone + '_ {
        let order = self.problem.order().iter();
        let mandatory = order.filter(|&&item| self.problem.items[item].mandatory);
        mandatory.filter_map(|&item| Some((item, self.slots[item]?)))
    }

    /// What the incumbent lists of those that are still in.
    fn exceeded(&self, incumbent: &TimedPlan) -> Exceeded {
        let known: BTreeSet<_> = self.mandatory().map(|(item, _)| self.id(item)).collect();
        let listed = incumbent.excess.iter();
        let listed = listed.filter(|one| one.by.is_some_and(|by| known.contains(&by)));
        listed.fold(Exceeded::default(), |all, one| match one.limit {
            Limit::Handover => Exceeded { handover: all.handover.max(one.amount), ..all },
            Limit::Data => Exceeded { data: true, ..all },
            _ => all,
        })
    }

    /// Whether its priors are over, and it breaks nothing beside what is placed
    /// of what does not depend on what is derived, but for the data's limit.
    fn fits_beside(&mut self, item: usize, slot: Slot) -> bool {
        let (start, end) = (slot.start.get(), slot.end.get());
        let after = self.after(item).is_ok_and(|after| after <= start);
        let apart = |block: &Block| end <= block.from || block.to <= start || start == end;
        let claim = self.claims[item].clone();
        self.timelines.remove(&claim, slot.start);
        let mut unlimited = claim.clone();
        unlimited.limited = false;
        let fits = self.timelines.valid_starts(&unlimited, (slot.start, slot.start));
        self.timelines.insert(&claim, slot.start);
        after && !fits.is_empty() && self.problem.blocks.iter().all(apart)
    }

    /// Whether there is room for the data of optional ones, from the first of them
    /// on; where mandatory ones are listed to exceed it: without what those bring.
    fn keeps_data(&self, slots: &[(usize, Slot)], listed: bool) -> bool {
        let limited = slots.iter().filter(|(item, _)| self.claims[*item].limited);
        let Some(first) = limited.map(|(_, slot)| slot.start).min() else { return true };
        let brings = |item: usize| self.claims[item].data.max(0);
        let brought = |at: Time| -> i64 {
            let begun = self.mandatory().filter(|(_, slot)| listed && slot.start <= at);
            begun.map(|(item, _)| brings(item)).sum()
        };
        let max = self.problem.plan.max_delta_data.get();
        self.timelines.volumes(first).all(|(at, total)| total - brought(at) <= max)
    }

    /// Whether no optional one breaks the minimum at handover: mandatory ones
    /// may. Either it is not lower than with them alone, or the optional ones
    /// alone keep it, and were placed before, or it is as the incumbent says.
    fn keeps_handover(&self, slots: &[(usize, Slot)], base: &World, listed: i64) -> bool {
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
        let base = base.charge(at);
        charge >= least.saturating_sub(listed).min(base)
            || charge >= alone(true)
            || alone(false) >= least.min(base)
    }

    /// What is exceeded in the end, mandatory ones exceed, also where none did
    /// when it was placed: the last of them says so.
    fn owns_up(&mut self, base: &World, lines: &Timelines) {
        let listed = |limit: &Limit| {
            let entries = self.excess.iter().filter(move |one| one.limit == *limit);
            entries.map(|one| one.amount).max()
        };
        let handover = self.short_at_handover(base);
        let handover = handover.filter(|short| listed(&Limit::Handover) < Some(short.1));
        let data = self.too_much(lines).filter(|_| listed(&Limit::Data).is_none());
        let last = |brings: bool| {
            let of = |&(item, _): &(usize, Slot)| !brings || self.claims[item].data > 0;
            self.mandatory().rev().find(of).map(|(item, _)| item)
        };
        let news = [(Limit::Handover, last(false), handover), (Limit::Data, last(true), data)];
        for (limit, by, exceeds) in news {
            let (Some(item), Some((at, amount))) = (by, exceeds) else { continue };
            let by = Some(self.id(item));
            self.excess.retain(|one| (one.by, &one.limit) != (by, &limit));
            self.excess.push(Excess { by, limit, at: Time::new(at), amount });
        }
    }

    /// How far the charge at handover is below its minimum, if it is lower than
    /// it would be anyway.
    fn short_at_handover(&self, base: &World) -> Option<(i64, i64)> {
        let at = self.problem.handover?;
        let (charge, min) = (self.world.charge(at), self.problem.battery.handover);
        (charge < min && charge < base.charge(at)).then_some((at, min - charge))
    }

    /// When there is too much data first, and more than there would be anyway.
    fn too_much(&self, lines: &Timelines) -> Option<(i64, i64)> {
        let max = self.problem.plan.max_delta_data.get();
        let now = Time::new(self.problem.now);
        let both = self.timelines.volumes(now).chain(lines.volumes(now));
        let instants: BTreeSet<Time> = both.map(|(at, _)| at).collect();
        let total = |of: &Timelines, at| of.volumes(at).next().map_or(0, |(_, total)| total);
        let over = instants.into_iter().map(|at| (at, total(&self.timelines, at)));
        let mut over = over.filter(|&(at, all)| all > max && all > total(lines, at));
        over.next().map(|(at, all)| (at.get(), all - max))
    }
}
