//! The plan that is being executed, kept where a new pass would come to less:
//! by trying, as slowly as the rest.

use std::cmp::Reverse;

use faregate_planner::timed::{Fate, TimedPlan};

use crate::brute::Pass;
use crate::candidates::{is_candidate, is_valid, may_start, ranges};
use crate::scene::{Placed, Scene};
use crate::valid::{
    Priors, beside, chosen, group_taken, handover, lead, peak, priors, soft_minimum, too_much_data,
};
use crate::world::World;

/// What a choice is worth, as a list that compares as worths do: mandatory
/// activities by priority, the values of the others, how many there are, how
/// early they are.
pub(crate) fn worth(scene: &Scene<'_>, placed: &[Placed]) -> Vec<i128> {
    let from = scene.parameters.mandatory_from;
    let priority = |index: usize| scene.activity(index).priority;
    let mut levels: Vec<Reverse<u32>> =
        scene.plan.activities.iter().map(|a| Reverse(a.priority)).collect();
    levels.sort_unstable();
    levels.dedup();
    let mandatory = levels.iter().filter(|level| level.0 >= from);
    let counted = mandatory.map(|level| {
        let of = placed.iter().filter(|one| priority(one.index) == level.0);
        i128::try_from(of.count()).unwrap_or(i128::MAX)
    });
    let mut all: Vec<i128> = counted.collect();
    let optional = placed.iter().filter(|one| scene.is_optional(one.index));
    all.push(optional.map(|one| i128::from(scene.activity(one.index).worth())).sum());
    all.push(i128::try_from(placed.len()).unwrap_or(i128::MAX));
    all.push(-placed.iter().map(|one| i128::from(one.start)).sum::<i128>());
    all
}

/// What an incumbent schedules and is still to be decided, in the order given.
pub(crate) fn wanted(scene: &Scene<'_>, incumbent: &TimedPlan, order: &[usize]) -> Vec<Placed> {
    let slot = |index: &usize| {
        let id = scene.activity(*index).id;
        let row = incumbent.rows.iter().find(|row| row.id == id)?;
        let Fate::Scheduled(slot) = row.fate else { return None };
        let (start, end) = (slot.start.get(), slot.end.get());
        let open = is_candidate(scene, *index) && start >= scene.now;
        open.then(|| chosen(*index, start, end))
    };
    order.iter().filter_map(slot).collect()
}

/// Everything that is wanted, where all of it together is valid; or else at the
/// starts that are wanted, as much as is.
pub(crate) fn keep(pass: &mut Pass<'_, '_>, wanted: &[Placed]) {
    if is_whole_valid(pass.scene, &pass.world, wanted) {
        return wanted.iter().for_each(|slot| pass.place(*slot));
    }
    loop {
        while wanted.iter().filter(|slot| place(pass, slot)).count() > 0 {}
        let longer = wanted.iter().filter(|slot| {
            let kept = pass.world.find(slot.index).filter(|kept| kept.start == slot.start);
            let before = kept.map_or(slot.end, |kept| kept.end);
            before < slot.end && pass.expand(slot.index, slot.end) > before
        });
        if longer.count() == 0 {
            return;
        }
    }
}

/// Whether all of it is valid at once, as compared to nothing of it: each one
/// beside all others in what they share, and all together in what is derived.
fn is_whole_valid(scene: &Scene<'_>, base: &World<'_>, wanted: &[Placed]) -> bool {
    let but = |out: &dyn Fn(&Placed) -> bool| {
        let rest = wanted.iter().filter(|one| !out(one));
        World::new(scene, base.placed.iter().chain(rest).copied().collect())
    };
    let with = but(&|_| false);
    let each = wanted.iter().all(|one| {
        let without = but(&|other| other.index == one.index);
        is_in_range(scene, one)
            && group_taken(scene, &with, one.index).is_none()
            && matches!(priors(scene, &with, one.index), Priors::From(at) if at <= one.start)
            && beside(scene, &without, &with, &[*one]).is_empty()
            && !(adds(scene, one) && too_much_data(scene, &without, &with).is_some())
    });
    // What mandatory ones break, optional ones may have kept before.
    let mandatory = but(&|one| scene.is_optional(one.index));
    let optional = but(&|one| !scene.is_optional(one.index));
    let handed_over =
        handover(scene, &mandatory, &with).is_none() || handover(scene, base, &optional).is_none();
    each && soft_minimum(scene, base, &with).is_none()
        && peak(scene, base, &with).is_none()
        && lead(base, &with).is_none()
        && handed_over
}

fn adds(scene: &Scene<'_>, one: &Placed) -> bool {
    scene.is_optional(one.index) && scene.activity(one.index).data.get() > 0
}

/// Whether a range admits it, at a length that it can have.
fn is_in_range(scene: &Scene<'_>, one: &Placed) -> bool {
    let activity = scene.activity(one.index);
    let (shortest, longest) = (activity.placed().get(), activity.duration.get());
    let early = one.start < scene.earliest(one.index);
    let admitted = activity.starts.iter().any(|range| {
        (range.from.get()..=range.to.get()).contains(&one.start)
            && one.end <= range.cutoff.get().min(scene.end)
    });
    !early && admitted && (shortest..=longest).contains(&(one.end - one.start))
}

/// At its start, if it is valid there. Whether it was placed.
fn place(pass: &mut Pass<'_, '_>, slot: &Placed) -> bool {
    let scene = pass.scene;
    let length = scene.activity(slot.index).placed().get();
    let short = chosen(slot.index, slot.start, slot.start + length);
    let from = may_start(scene, &pass.world, slot.index);
    let within = from.into_iter().flat_map(|from| ranges(scene, slot.index, from));
    let fits = pass.world.find(slot.index).is_none()
        && within.into_iter().any(|(first, last)| (first..=last).contains(&slot.start))
        && is_valid(scene, &pass.world, &short);
    if fits {
        pass.place(short);
    }
    fits
}
