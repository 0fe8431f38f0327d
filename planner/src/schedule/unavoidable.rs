//! What is broken whatever is planned: by the base load, windows, manual
//! shutdowns, what runs, and what is committed.

use crate::derive::World;
use crate::judge::keeps;
use crate::problem::Known;
use crate::timed::{Excess, Limit};
use crate::units::Time;

use super::Pass;

/// What is broken before anything is planned.
pub(super) fn unavoidable(pass: &Pass<'_>) -> Vec<Excess> {
    let problem = pass.problem;
    let battery = &problem.battery;
    let mut all = Vec::new();
    let mut is = |limit, at: Option<i64>, amount: i64| {
        if let Some(at) = at {
            all.push(Excess { by: None, limit, at: Time::new(at), amount });
        }
    };
    let low = first_below(&pass.world, battery.soft);
    is(Limit::SoftMinimum, low, battery.soft - low.map_or(0, |at| pass.world.charge(at)));
    if let Some(at) = problem.handover {
        let charge = pass.world.charge(at);
        let below = (charge < battery.handover).then_some(at);
        is(Limit::Handover, below, battery.handover - charge);
    }
    let max = problem.plan.max_delta_data.get();
    let data = pass.timelines.volumes(Time::new(problem.now)).find(|(_, total)| *total > max);
    is(Limit::Data, data.map(|(at, _)| at.get()), data.map_or(0, |(_, total)| total - max));
    let peak = pass.world.pieces.iter().find(|piece| piece.peak > problem.peak_limit);
    is(Limit::Peak, peak.map(|it| it.from), peak.map_or(0, |it| it.peak - problem.peak_limit));
    let engines = pass.timelines.engines();
    let most = i64::from(problem.parameters.engines);
    let past = engines.points.iter().find(|(at, used)| at.get() >= problem.now && *used > most);
    is(Limit::Engines, past.map(|(at, _)| at.get()), past.map_or(0, |(_, used)| used - most));
    if let Some(twice) = pass.timelines.held_twice() {
        is(Limit::Resources(twice.bits), Some(twice.at.get()), twice.ms);
    }
    for (name, at, amount) in pass.timelines.out_of_range() {
        is(Limit::Timeline(name.to_owned()), Some(at.get()), amount);
    }
    if let Some((at, until)) = needed_in_a_block(pass) {
        is(Limit::Computer, Some(at), until - at);
    }
    all
}

/// The first time at which something needs the computer while the ground has it
/// off: windows come from elsewhere, and what runs may take longer than it was
/// thought to.
fn needed_in_a_block(pass: &Pass<'_>) -> Option<(i64, i64)> {
    let mut met = pass.needed_in_blocks();
    met.sort_unstable();
    met.into_iter().reduce(
        |(at, until), (from, to)| {
            if from <= until { (at, until.max(to)) } else { (at, until) }
        },
    )
}

impl Pass<'_> {
    /// When windows and what is placed need the computer, in no order.
    pub(crate) fn needs_computer(&self) -> Vec<(i64, i64)> {
        let windows = self.problem.state.windows.iter().filter(|window| window.awake);
        let windows = windows.map(|window| (window.start.get(), window.end.get()));
        let slots = self.slots.iter().zip(&self.problem.items);
        let slots = slots.filter(|(_, item)| !matches!(item.fate, Known::Block(_)));
        let slots = slots.filter_map(|(slot, _)| slot.map(|it| (it.start.get(), it.end.get())));
        let heats = self.placed.zones.iter().flat_map(|zone| zone.heats.iter().flatten());
        let all = windows.chain(slots).chain(heats.map(|heat| (heat.from, heat.to)));
        let (now, end) = (self.problem.now, self.problem.end);
        let seen = all.map(|(from, to)| (from.max(now), to.min(end)));
        seen.filter(|(from, to)| from < to).collect()
    }

    /// The same, in manual blocks.
    fn needed_in_blocks(&self) -> Vec<(i64, i64)> {
        let needs = self.needs_computer().into_iter();
        let met = needs.flat_map(|(from, to)| {
            let blocks = self.problem.blocks.iter();
            blocks.map(move |block| (from.max(block.from), to.min(block.to)))
        });
        met.filter(|(from, to)| from < to).collect()
    }

    /// Whether no window and nothing that is placed needs the computer in a
    /// manual block.
    pub(crate) fn is_apart_from_blocks(&self) -> bool {
        self.needed_in_blocks().is_empty()
    }

    /// Whether what this one takes is free for it where it is.
    pub(crate) fn is_free_for(&mut self, item: usize) -> bool {
        let Some(slot) = self.slots[item] else { return true };
        let claim = &self.claims[item];
        self.timelines.remove(claim, slot.start);
        let within = (slot.start, slot.start);
        let is_free = !self.timelines.valid_starts(claim, within).is_empty();
        self.timelines.insert(claim, slot.start);
        is_free
    }

    /// Whether what is placed, all of it together, breaks nothing of what depends
    /// on what is derived that is not broken with nothing placed.
    pub(crate) fn keeps_by_itself(&self) -> bool {
        let problem = self.problem;
        let base = Pass::new(problem, None).world;
        let placed = self.slots.iter().zip(&problem.items).filter(|(slot, _)| slot.is_some());
        // The minimum at handover is one that mandatory ones may break.
        let mut chosen = placed.map(|(_, item)| item).filter(|item| item.is_candidate());
        let handover = problem.handover.is_none_or(|at| {
            let least = problem.battery.handover.min(base.charge(at));
            chosen.any(|item| item.mandatory) || self.world.charge(at) >= least
        });
        handover && keeps(problem, (&self.placed, &self.world), &base)
    }
}

/// The first instant at which the charge is below a limit.
fn first_below(world: &World, limit: i64) -> Option<i64> {
    for (at, piece) in world.pieces.iter().enumerate() {
        if piece.charge < limit {
            return Some(piece.from);
        }
        let until = world.until(at);
        if piece.net < 0 && until != i64::MAX && world.charge_in(at, until) < limit {
            return Some(piece.from + (piece.charge - limit) / -piece.net + 1);
        }
    }
    None
}
