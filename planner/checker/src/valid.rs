//! Whether one more activity can be placed, or last longer, with everything
//! derived anew.

use faregate_planner::parameters::TimelineSpec;
use faregate_planner::plan::{ActivityId, Outcome, Status};
use faregate_planner::timed::Limit;

use crate::lines::{both_hold, data, engines, named, overlap};
use crate::scene::{How, Placed, Scene};
use crate::steps::first_past;
use crate::world::{Flaw, World, needs};

/// A limit that one more activity would break.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Broken {
    pub(crate) limit: Limit,
    pub(crate) at: i64,
    pub(crate) amount: i128,
    pub(crate) with: Option<ActivityId>,
}

impl Broken {
    const fn of(limit: Limit, at: i64, amount: i128) -> Self {
        Self { limit, at, amount, with: None }
    }
}

/// What an activity's dependencies allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Priors {
    /// A start from then on.
    From(i64),
    /// None, because of this one.
    Ended(ActivityId, Outcome),
    Out(ActivityId),
    Waits(ActivityId),
}

/// The first of the limits that stands against `one` in `with`, as compared to
/// the world without it.
pub(crate) fn broken(
    scene: &Scene<'_>,
    without: &World<'_>,
    with: &World<'_>,
    one: &Placed,
) -> Option<Broken> {
    None.or_else(|| soft_minimum(scene, without, with))
        .or_else(|| handover(scene, without, with).filter(|_| scene.is_optional(one.index)))
        .or_else(|| {
            let adds = scene.activity(one.index).data.get() > 0;
            too_much_data(scene, without, with).filter(|_| scene.is_optional(one.index) && adds)
        })
        .or_else(|| peak(scene, without, with))
        .or_else(|| beside(scene, without, with, &[*one]).into_iter().next())
        .or_else(|| lead(without, with))
}

/// The limits in which the order of placing does not matter: `ours` are in
/// `with` beside what is in `without`.
pub(crate) fn beside(
    scene: &Scene<'_>,
    without: &World<'_>,
    with: &World<'_>,
    ours: &[Placed],
) -> Vec<Broken> {
    let mut all: Vec<Broken> = engine(scene, without, with).into_iter().collect();
    all.extend(ours.iter().filter_map(|one| resources(scene, with, one)));
    all.extend(timelines(scene, without, with, ours));
    all.extend(computer(scene, with, ours));
    all
}

pub(crate) fn soft_minimum(
    scene: &Scene<'_>,
    without: &World<'_>,
    with: &World<'_>,
) -> Option<Broken> {
    let least = scene.at_least(scene.parameters.soft_min_soc);
    let below = with.charge.first_below(least, Some(&without.charge), (scene.now, scene.end));
    below.map(|(at, by)| Broken::of(Limit::SoftMinimum, at, by))
}

/// The shortfall at handover, if the charge is lower than without.
pub(crate) fn handover(scene: &Scene<'_>, without: &World<'_>, with: &World<'_>) -> Option<Broken> {
    let at = scene.plan.handover.get();
    let least = scene.at_least(scene.plan.handover_min_soc);
    let (charge, before) = (with.charge.at(at), without.charge.at(at));
    let applies = at >= scene.now && charge < least && charge < before;
    applies.then(|| Broken::of(Limit::Handover, at, least - charge))
}

/// Where the data is past its limit, and further than without.
pub(crate) fn too_much_data(
    scene: &Scene<'_>,
    without: &World<'_>,
    with: &World<'_>,
) -> Option<Broken> {
    let most = i128::from(scene.plan.max_delta_data.get());
    let (without, with) = (data(scene, &without.placed), data(scene, &with.placed));
    let past = first_past(&with, &without, most, (scene.now, scene.end));
    past.map(|(at, by)| Broken::of(Limit::Data, at, by))
}

pub(crate) fn peak(scene: &Scene<'_>, without: &World<'_>, with: &World<'_>) -> Option<Broken> {
    let most = i128::from(scene.parameters.peak_limit.get());
    let past = first_past(&with.peak, &without.peak, most, (scene.now, scene.end));
    past.map(|(at, by)| Broken::of(Limit::Peak, at, by))
}

fn engine(scene: &Scene<'_>, without: &World<'_>, with: &World<'_>) -> Option<Broken> {
    let (without, with) = (engines(scene, &without.placed), engines(scene, &with.placed));
    let most = scene.parameters.engines.into();
    let past = first_past(&with, &without, most, (scene.now, scene.end));
    past.map(|(at, by)| Broken::of(Limit::Engines, at, by))
}

fn resources(scene: &Scene<'_>, with: &World<'_>, one: &Placed) -> Option<Broken> {
    let bits = scene.activity(one.index).resources;
    let slot = (one.start, one.end);
    let windows = scene.state.windows.iter();
    let windows = windows.map(|w| (None, w.resources, (w.start.get(), w.end.get())));
    let others = with.placed.iter().filter(|other| other.index != one.index).map(|other| {
        let activity = scene.activity(other.index);
        (Some(activity.id), activity.resources, (other.start, other.end))
    });
    let clashes = others.chain(windows).filter_map(|(with, held, other)| {
        let at = overlap(slot, other)?;
        let limit = Limit::Resources(held.shared(bits).mask());
        held.overlaps(bits).then_some(Broken { limit, at, amount: 0, with })
    });
    clashes.min_by_key(|clash| clash.at)
}

fn timelines(
    scene: &Scene<'_>,
    without: &World<'_>,
    with: &World<'_>,
    ours: &[Placed],
) -> Option<Broken> {
    scene.parameters.timelines.iter().find_map(|spec| {
        let first = timeline(scene, without, with, ours, spec)?;
        Some(Broken::of(Limit::Timeline(spec.name.clone()), first.0, first.1))
    })
}

/// When a timeline first leaves its limits, or what is asked of it.
fn timeline(
    scene: &Scene<'_>,
    without: &World<'_>,
    with: &World<'_>,
    ours: &[Placed],
    spec: &TimelineSpec,
) -> Option<(i64, i128)> {
    let (before, line) = (named(scene, &without.placed, spec), named(scene, &with.placed, spec));
    let (lower, upper) = (line.negated(), before.negated());
    let outside = |min: i64, max: i64, compare: bool, within| {
        let (min, max) = (i128::from(min) * 1_000, i128::from(max) * 1_000);
        let low = line.first_below(min, compare.then_some(&before), within);
        let high = lower.first_below(-max, compare.then_some(&upper), within);
        low.into_iter().chain(high).min()
    };
    let is_ours = |placed: &Placed| ours.iter().any(|one| one.index == placed.index);
    let always = outside(spec.min, spec.max, true, (scene.now, scene.end));
    let asked = with.placed.iter().flat_map(|placed| {
        let theirs = scene.activity(placed.index).constraints.iter();
        theirs.filter(|c| c.timeline == spec.name).map(move |c| (placed, c))
    });
    let asked = asked.filter_map(|(placed, constraint)| {
        let within = (placed.start.max(scene.now), placed.end - 1);
        outside(constraint.min, constraint.max, !is_ours(placed), within)
    });
    let held = ours.iter().flat_map(|one| {
        let others = with.placed.iter().filter(|other| other.index != one.index);
        others.filter_map(|other| Some((both_hold(scene, one, other, spec)?, 0)))
    });
    let first = always.into_iter().chain(asked).chain(held).min()?;
    // A thousandth of a unit past a limit is past it.
    Some((first.0, (first.1 + 999) / 1_000))
}

fn computer(scene: &Scene<'_>, with: &World<'_>, ours: &[Placed]) -> Option<Broken> {
    let needs = needs(scene, ours, &with.heatings, false);
    let clashes = scene.manual().into_iter().flat_map(|block| {
        needs.clone().into_iter().filter_map(move |need| overlap(need, (block.start, block.end)))
    });
    clashes.min().map(|at| Broken::of(Limit::Computer, at, 0))
}

pub(crate) fn lead(without: &World<'_>, with: &World<'_>) -> Option<Broken> {
    let is_old =
        |flaw: &&Flaw| without.flaws.iter().any(|old| (old.index, old.at) == (flaw.index, flaw.at));
    let fresh = with.flaws.iter().find(|flaw| !is_old(flaw))?;
    Some(Broken::of(Limit::Lead, fresh.at, fresh.by.into()))
}

/// What dependencies allow, with these placed.
pub(crate) fn priors(scene: &Scene<'_>, world: &World<'_>, index: usize) -> Priors {
    let mut from = scene.earliest(index);
    let after = &scene.activity(index).after;
    let judged = after.iter().map(|d| (d.prior, prior(scene, world, d.prior, &d.statuses)));
    let judged: Vec<(ActivityId, Priors)> = judged.collect();
    let rank = |priors: &Priors| match priors {
        Priors::Ended(..) => 0,
        Priors::Out(_) => 1,
        Priors::Waits(_) => 2,
        Priors::From(_) => 3,
    };
    if let Some((_, worst)) = judged.iter().min_by_key(|(_, priors)| rank(priors))
        && rank(worst) < 3
    {
        return *worst;
    }
    for (_, priors) in judged {
        if let Priors::From(at) = priors {
            from = from.max(at);
        }
    }
    Priors::From(from)
}

fn prior(scene: &Scene<'_>, world: &World<'_>, id: ActivityId, any: &[Status]) -> Priors {
    if let Some(ended) = scene.ended(id) {
        let right = any.iter().any(|status| status.includes(ended.outcome));
        return if right { Priors::From(scene.now) } else { Priors::Ended(id, ended.outcome) };
    }
    let placed = scene.index(id).and_then(|index| world.find(index));
    let hopes = any.iter().any(|s| matches!(s, Status::Succeeded | Status::Completed));
    match placed {
        None => Priors::Out(id),
        Some(_) if !hopes => Priors::Waits(id),
        Some(placed) => Priors::From(placed.end),
    }
}

/// The member of its group that was selected or has started.
pub(crate) fn group_taken(
    scene: &Scene<'_>,
    world: &World<'_>,
    index: usize,
) -> Option<ActivityId> {
    let group = scene.activity(index).group.as_ref()?;
    let members = scene.plan.activities.iter().enumerate();
    let mut others =
        members.filter(|(i, other)| *i != index && other.group.as_ref() == Some(group));
    let taken = others.find(|(i, other)| {
        let started = scene.ended(other.id).is_some_and(|ended| ended.started.is_some());
        started || world.find(*i).is_some()
    });
    taken.map(|(_, other)| other.id)
}

/// A chosen slot.
pub(crate) const fn chosen(index: usize, start: i64, end: i64) -> Placed {
    Placed { index, start, end, how: How::Chosen }
}
