//! Which starts a candidate has, and whether it can be placed at one.

use faregate_planner::plan::StartRange;

use crate::scene::{How, Placed, Scene, block};
use crate::valid::{Broken, Priors, broken, chosen, group_taken, handover, priors, too_much_data};
use crate::world::World;

/// Candidates, the most important first.
pub(crate) fn order(scene: &Scene<'_>) -> Vec<usize> {
    let activities = &scene.plan.activities;
    let mut order: Vec<usize> = (0..activities.len()).collect();
    order.retain(|index| is_candidate(scene, *index));
    order.sort_by_key(|index| std::cmp::Reverse(activities[*index].priority));
    order
}

/// Whether anything is to be decided about it.
pub(crate) fn is_candidate(scene: &Scene<'_>, index: usize) -> bool {
    let activity = scene.activity(index);
    let fixed = scene.fixed.iter().any(|placed| placed.index == index);
    !fixed && scene.ended(activity.id).is_none() && block(index, activity).is_none()
}

/// Limits that a mandatory activity exceeds because it may.
pub(crate) fn excesses(scene: &Scene<'_>, without: &World<'_>, with: &World<'_>) -> Vec<Broken> {
    handover(scene, without, with).into_iter().chain(too_much_data(scene, without, with)).collect()
}

/// The earliest valid slot, by trying every start.
pub(crate) fn earliest(scene: &Scene<'_>, world: &World<'_>, index: usize) -> Option<Placed> {
    let from = may_start(scene, world, index)?;
    let mut starts: Vec<i64> =
        ranges(scene, index, from).into_iter().flat_map(|(first, last)| first..=last).collect();
    starts.sort_unstable();
    starts.dedup();
    let length = scene.activity(index).placed().get();
    let slots = starts.into_iter().map(|start| chosen(index, start, start + length));
    slots.into_iter().find(|slot| is_valid(scene, world, slot))
}

/// From when on dependencies and its group let it start.
pub(crate) fn may_start(scene: &Scene<'_>, world: &World<'_>, index: usize) -> Option<i64> {
    match (priors(scene, world, index), group_taken(scene, world, index)) {
        (Priors::From(from), None) => Some(from),
        _ => None,
    }
}

/// The starts that its ranges leave, both ends inclusive.
pub(crate) fn ranges(scene: &Scene<'_>, index: usize, from: i64) -> Vec<(i64, i64)> {
    let activity = scene.activity(index);
    let length = activity.placed().get();
    let starts = activity.starts.iter().map(|range| {
        let last = range.to.get().min(range.cutoff.get() - length).min(scene.end - length);
        (range.from.get().max(from), last)
    });
    starts.filter(|(first, last)| first <= last).collect()
}

/// Whether it can be placed there.
pub(crate) fn is_valid(scene: &Scene<'_>, world: &World<'_>, slot: &Placed) -> bool {
    broken(scene, world, &world.with(scene, *slot), slot).is_none()
}

/// The first range that admits a slot.
pub(crate) fn range_of(scene: &Scene<'_>, slot: &Placed) -> usize {
    let starts = &scene.activity(slot.index).starts;
    let admits = |range: &StartRange| {
        range.from.get() <= slot.start
            && slot.start <= range.to.get()
            && slot.end <= range.cutoff.get()
    };
    starts.iter().position(admits).unwrap_or(0)
}

/// The world in which it lasts a millisecond longer, if everything stays valid.
pub(crate) fn longer<'a>(
    scene: &Scene<'a>,
    before: &World<'a>,
    world: &World<'a>,
    index: usize,
) -> Option<World<'a>> {
    let slot = *world.find(index)?;
    let end = slot.end + 1;
    let activity = scene.activity(index);
    let range = activity.starts.get(range_of(scene, &slot))?;
    let within = end - slot.start <= activity.duration.get()
        && end <= range.cutoff.get().min(scene.end)
        && !hurries(scene, world, index, end);
    let slot = Placed { end, ..slot };
    let placed = world.placed.iter().map(|p| if p.index == index { slot } else { *p }).collect();
    let with = World::new(scene, placed);
    // Only the minimum is mandatory; and a downlink that ends later leaves less
    // room until then.
    let free =
        broken(scene, before, &with, &slot).is_none() && excesses(scene, before, &with).is_empty();
    (within && free && slot.how == How::Chosen).then_some(with)
}

/// Whether a dependant has started by then.
fn hurries(scene: &Scene<'_>, world: &World<'_>, index: usize, end: i64) -> bool {
    let id = scene.activity(index).id;
    world.placed.iter().any(|placed| {
        let after = &scene.activity(placed.index).after;
        placed.start < end && after.iter().any(|dependency| dependency.prior == id)
    })
}
