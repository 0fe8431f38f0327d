//! The pass again, with the starts that a plan gives: each was valid at its
//! turn.

use faregate_planner::timed::Excess;

use crate::brute::exceeded;
use crate::candidates::order;
use crate::given::Given;
use crate::scene::Placed;
use crate::shared::violation;
use crate::valid::{Priors, broken, chosen, group_taken, priors};
use crate::violation::{Rule, Violation};
use crate::world::World;

pub(crate) fn check(given: &Given<'_>) -> Vec<Violation> {
    let mut world = given.base.clone();
    let mut waiting: Vec<Placed> =
        order(given.scene).iter().filter_map(|index| slot(given, *index)).collect();
    let mut excess = Vec::new();
    loop {
        let before = waiting.len();
        waiting.retain(|slot| !place(given, &mut world, slot, &mut excess));
        if waiting.is_empty() {
            return listed(given, &excess);
        }
        // What fits only now may have needed the others at their full length.
        let expanded = expanded(given, &world);
        if waiting.len() == before && expanded != world.placed {
            world = World::new(given.scene, expanded);
        } else if waiting.len() == before {
            return waiting.iter().map(|slot| refused(given, &world, slot)).collect();
        }
    }
}

/// The slot that it was placed in, before anything was expanded.
fn slot(given: &Given<'_>, index: usize) -> Option<Placed> {
    let placed = given.world.find(index)?;
    let length = given.scene.activity(index).placed().get();
    Some(chosen(index, placed.start, placed.start + length))
}

/// Those placed so far, as long as they last in the end.
fn expanded(given: &Given<'_>, world: &World<'_>) -> Vec<Placed> {
    let last = |placed: &Placed| given.world.find(placed.index).copied().unwrap_or(*placed);
    world.placed.iter().map(last).collect()
}

/// Whether it is valid now.
fn place<'a>(
    given: &Given<'a>,
    world: &mut World<'a>,
    slot: &Placed,
    excess: &mut Vec<Excess>,
) -> bool {
    let scene = given.scene;
    let with = world.with(scene, *slot);
    let allowed = matches!(priors(scene, world, slot.index), Priors::From(at) if at <= slot.start);
    let free = group_taken(scene, world, slot.index).is_none();
    if !allowed || !free || broken(scene, world, &with, slot).is_some() {
        return false;
    }
    if !scene.is_optional(slot.index) {
        excess.extend(exceeded(scene, world, &with, slot.index));
    }
    *world = with;
    true
}

fn refused<'a>(given: &Given<'a>, world: &World<'a>, slot: &Placed) -> Violation {
    let scene = given.scene;
    let with = world.with(scene, *slot);
    let who = Some(given.id(slot));
    match broken(scene, world, &with, slot) {
        Some(broken) => violation(broken, who),
        None => Violation::new(Rule::Dependency, who, slot.start).detail("not at its turn"),
    }
}

/// What was exceeded is what is listed.
fn listed(given: &Given<'_>, excess: &[Excess]) -> Vec<Violation> {
    let listed = &given.timed.excess;
    let missing = excess.iter().filter(|one| !listed.contains(one)).map(|one| (one, "missing"));
    let false_ones = listed.iter().filter(|one| !excess.contains(one)).map(|one| (one, "false"));
    missing
        .chain(false_ones)
        .map(|(one, what)| {
            let detail = format!("{what}: {one:?}");
            Violation::new(Rule::Excess, one.by, one.at.get()).detail(detail)
        })
        .collect()
}
