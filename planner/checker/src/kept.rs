//! The plan that is being executed, kept where a new pass would come to less:
//! by trying, as slowly as the rest.

use std::cmp::Reverse;

use faregate_planner::timed::{Fate, Limit, TimedPlan};

use crate::brute::{Pass, listed};
use crate::candidates::{excesses, is_candidate, is_valid, may_start, ranges};
use crate::lines::data;
use crate::scene::{How, Placed, Scene};
use crate::valid::{
    Priors, beside, chosen, group_taken, handover, lead, peak, priors, soft_minimum,
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
pub(crate) fn keep(pass: &mut Pass<'_, '_>, incumbent: &TimedPlan, wanted: &[Placed]) {
    let base = pass.world.clone();
    if is_whole_valid(pass.scene, &base, incumbent, wanted) {
        wanted.iter().for_each(|slot| pass.place(*slot));
        return owns_up(pass, &base);
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

/// What is exceeded in the end although none of the mandatory ones exceeded it
/// so far when it was placed, the last of them is listed for.
fn owns_up(pass: &mut Pass<'_, '_>, base: &World<'_>) {
    let scene = pass.scene;
    for broken in excesses(scene, base, &pass.world) {
        let entries = pass.excess.iter().filter(|one| one.limit == broken.limit);
        let is_enough =
            |amount: i64| broken.limit == Limit::Data || i128::from(amount) >= broken.amount;
        if entries.clone().any(|one| is_enough(one.amount)) {
            continue;
        }
        let brings =
            |index: usize| broken.limit == Limit::Handover || scene.activity(index).data.get() > 0;
        let could = mandatory(scene, &pass.world).filter(|one| brings(one.index));
        // Of equally important ones the later in the plan comes later.
        let rank = |one: &Placed| (Reverse(scene.activity(one.index).priority), one.index);
        if let Some(last) = could.max_by_key(rank) {
            let by = Some(scene.activity(last.index).id);
            pass.excess.retain(|one| one.by != by || one.limit != broken.limit);
            pass.excess.push(listed(by, broken));
        }
    }
}

/// Those that were decided on and may exceed what others may not.
fn mandatory<'w>(scene: &'w Scene<'_>, world: &'w World<'_>) -> impl Iterator<Item = Placed> + 'w {
    let decided = |one: &&Placed| matches!(one.how, How::Chosen | How::Committed);
    let all = world.placed.iter().filter(decided).copied();
    all.filter(|one| !scene.is_optional(one.index))
}

/// Whether all of it is valid at once, as compared to nothing of it: each one
/// beside all others in what they share, and all together in what is derived.
fn is_whole_valid(
    scene: &Scene<'_>,
    base: &World<'_>,
    incumbent: &TimedPlan,
    wanted: &[Placed],
) -> bool {
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
    });
    // What mandatory ones break, optional ones may have kept before.
    let lacks = but(&|one| scene.is_optional(one.index));
    let optional = but(&|one| !scene.is_optional(one.index));
    let listed = listed_of(scene, &with, incumbent, &Limit::Handover);
    let handed_over = handover(scene, &lacks, &with).is_none()
        || handover(scene, base, &optional).is_none()
        || handover(scene, base, &with).is_none_or(|it| Some(it.amount) <= listed);
    each && soft_minimum(scene, base, &with).is_none()
        && peak(scene, base, &with).is_none()
        && lead(base, &with).is_none()
        && handed_over
        && data_fits(scene, &with, incumbent)
}

/// By how much the incumbent says that mandatory ones exceed a limit, of those
/// that are still in.
fn listed_of(
    scene: &Scene<'_>,
    with: &World<'_>,
    incumbent: &TimedPlan,
    limit: &Limit,
) -> Option<i128> {
    let is_in = |by| mandatory(scene, with).any(|one| scene.activity(one.index).id == by);
    let entries = incumbent.excess.iter().filter(|one| one.limit == *limit);
    let entries = entries.filter(|one| one.by.is_some_and(is_in));
    entries.map(|one| i128::from(one.amount)).max()
}

/// From where the first optional one that makes data begins, there is never too
/// much: not counting what mandatory ones make, where they are listed for it.
fn data_fits(scene: &Scene<'_>, with: &World<'_>, incumbent: &TimedPlan) -> bool {
    let makes = |one: &Placed| scene.activity(one.index).data.get() > 0;
    let chosen = with.placed.iter().filter(|one| one.how == How::Chosen);
    let optional = chosen.filter(|one| makes(one) && scene.is_optional(one.index));
    let Some(first) = optional.map(|one| one.start).min() else { return true };
    let listed = listed_of(scene, with, incumbent, &Limit::Data).is_some();
    let excused: Vec<usize> =
        mandatory(scene, with).filter(|one| listed && makes(one)).map(|one| one.index).collect();
    let counted = with.placed.iter().filter(|one| !excused.contains(&one.index));
    let total = data(scene, &counted.copied().collect::<Vec<_>>());
    let most = i128::from(scene.plan.max_delta_data.get());
    (first..=scene.end).all(|at| total.at(at) <= most)
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
