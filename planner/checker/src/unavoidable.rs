//! Limits that windows, running activities and manual blocks break by
//! themselves.

use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::plan::Effect;
use faregate_planner::timed::{Excess, Limit};

use crate::brute::listed;
use crate::given::Given;
use crate::lines::{data, engines, named};
use crate::scene::{Placed, Scene};
use crate::steps::{Changes, Steps, first_past};
use crate::valid::Broken;
use crate::violation::{Rule, Violation};
use crate::world::{World, needs};

/// As it is listed.
pub(crate) fn unavoidable(scene: &Scene<'_>, base: &World<'_>) -> Vec<Excess> {
    broken_by_themselves(scene, base).into_iter().map(|broken| listed(None, broken)).collect()
}

/// What is broken whatever is planned: exactly what the world breaks in which
/// nothing was chosen.
pub(crate) fn check(given: &Given<'_>) -> Vec<Violation> {
    let found = broken_by_themselves(given.scene, &given.base);
    let listed = &given.timed.unavoidable;
    let missing = found.iter().filter(|broken| {
        !listed.iter().any(|excess| {
            excess.limit == broken.limit
                && excess.at.get() == broken.at
                && i128::from(excess.amount) == broken.amount
        })
    });
    let invented = listed.iter().filter(|excess| !found.iter().any(|it| it.limit == excess.limit));
    let missing = missing.map(|broken| {
        let detail = format!("{:?} is broken by {} and not listed", broken.limit, broken.amount);
        Violation::new(Rule::Unavoidable, None, broken.at).detail(detail)
    });
    let invented = invented.map(|excess| {
        let detail = format!("{:?} is listed and not broken", excess.limit);
        Violation::new(Rule::Unavoidable, excess.by, excess.at.get()).detail(detail)
    });
    missing.chain(invented).collect()
}

fn broken_by_themselves(scene: &Scene<'_>, base: &World<'_>) -> Vec<Broken> {
    let all = (scene.now, scene.end);
    let of = |limit: Limit, found: Option<(i64, i128)>| {
        found.map(|(at, amount)| Broken { limit, at, amount, with: None })
    };
    let soft = scene.at_least(scene.parameters.soft_min_soc);
    let (handover, least) =
        (scene.plan.handover.get(), scene.at_least(scene.plan.handover_min_soc));
    let short = least - base.charge.at(handover);
    let nothing = Changes::default().from(scene.now);
    let past = |steps, limit: i128| first_past(steps, &nothing, limit, all);
    let data = data(scene, &base.placed);
    let engines = engines(scene, &base.placed);
    let power = [
        of(Limit::SoftMinimum, base.charge.first_below(soft, None, all)),
        of(Limit::Handover, (handover >= scene.now && short > 0).then_some((handover, short))),
        of(Limit::Data, past(&data, scene.plan.max_delta_data.get().into())),
        of(Limit::Peak, past(&base.peak, scene.parameters.peak_limit.get().into())),
        of(Limit::Engines, past(&engines, scene.parameters.engines.into())),
    ];
    let held = held_twice(scene, &base.placed);
    let named = scene.parameters.timelines.iter().map(|spec| {
        of(Limit::Timeline(spec.name.clone()), out_of_range(scene, &base.placed, spec))
    });
    let computer = [of(Limit::Computer, in_blocks(scene, base))];
    power.into_iter().chain([held]).chain(named).chain(computer).flatten().collect()
}

/// When the computer is needed in a manual block first, and for how long on end.
fn in_blocks(scene: &Scene<'_>, base: &World<'_>) -> Option<(i64, i128)> {
    let mut changes = Changes::default();
    for (start, end) in needs(scene, &base.placed, &base.heatings, true) {
        for block in scene.manual() {
            let (from, to) = (start.max(block.start), end.min(block.end).min(scene.end));
            if from.max(scene.now) < to {
                changes.add_over(from.max(scene.now), to, 1);
            }
        }
    }
    let needed = changes.from(scene.now);
    let instants: Vec<i64> = needed.instants().collect();
    let at = instants.iter().copied().find(|at| needed.at(*at) > 0)?;
    let until = instants.into_iter().find(|until| *until > at && needed.at(*until) == 0);
    Some((at, i128::from(until.unwrap_or(scene.end) - at)))
}

/// When each bit is held, by windows and by what is placed.
fn holders(scene: &Scene<'_>, placed: &[Placed]) -> Vec<(u128, Steps)> {
    let windows = scene.state.windows.iter();
    let windows = windows.map(|w| (w.resources.mask(), w.start.get(), w.end.get()));
    let placed = placed.iter();
    let placed = placed.map(|p| (scene.activity(p.index).resources.mask(), p.start, p.end));
    let claims: Vec<_> = windows.chain(placed).collect();
    let bits = (0..128).map(|bit| 1_u128 << bit);
    bits.map(|bit| {
        let mut changes = Changes::default();
        for (_, start, end) in claims.iter().filter(|(mask, ..)| mask & bit != 0) {
            changes.add_over(*start, *end, 1);
        }
        (bit, changes.from(scene.now))
    })
    .collect()
}

/// The first instant at which a bit is held by two, all bits that are then, and
/// for how long any of them is.
fn held_twice(scene: &Scene<'_>, placed: &[Placed]) -> Option<Broken> {
    let holders = holders(scene, placed);
    let mut instants: Vec<i64> = holders.iter().flat_map(|(_, held)| held.instants()).collect();
    instants.push(scene.end);
    instants.retain(|at| *at <= scene.end);
    instants.sort_unstable();
    let twice = |at: i64| {
        let all = holders.iter().filter(|(_, held)| held.at(at) > 1);
        all.fold(0, |mask, (bit, _)| mask | bit)
    };
    let at = instants.iter().copied().find(|at| twice(*at) != 0)?;
    let mask = twice(at);
    let free = instants.iter().copied().find(|free| *free > at && twice(*free) & mask == 0);
    let amount = i128::from(free.unwrap_or(scene.end) - at);
    Some(Broken { limit: Limit::Resources(mask), at, amount, with: None })
}

/// The first instant at which a timeline is out of its range, or one that is
/// asked for, or a unit is held by two; and by how much at most then.
fn out_of_range(scene: &Scene<'_>, placed: &[Placed], spec: &TimelineSpec) -> Option<(i64, i128)> {
    let line = named(scene, placed, spec);
    let upside_down = line.negated();
    let asked = placed.iter().flat_map(|one| {
        let asked = scene.activity(one.index).constraints.iter();
        let asked = asked.filter(|it| it.timeline == spec.name);
        let span = (one.start.max(scene.now), (one.end - 1).min(scene.end));
        asked.map(move |it| (it.min, it.max, span))
    });
    let all = asked.chain([(spec.min, spec.max, (scene.now, scene.end))]);
    let off = all.filter(|(.., span)| span.0 <= span.1).flat_map(|(min, max, span)| {
        let low = line.first_below(i128::from(min) * 1_000, None, span);
        let high = upside_down.first_below(i128::from(max) * -1_000, None, span);
        [low, high]
    });
    let (at, by) = off.flatten().chain(users(scene, placed, spec)).reduce(|a, b| match () {
        () if a.0 != b.0 => a.min(b),
        () => a.max(b),
    })?;
    Some((at, (by + 999) / 1_000))
}

/// When a unit has two users first, and how many too many, a thousand times.
fn users(scene: &Scene<'_>, placed: &[Placed], spec: &TimelineSpec) -> Option<(i64, i128)> {
    let mut changes = Changes::default();
    for one in placed {
        let mut impacts = scene.activity(one.index).impacts.iter();
        if impacts.any(|it| it.timeline == spec.name && matches!(it.effect, Effect::Hold(_))) {
            changes.add_over(one.start, one.end, 1);
        }
    }
    let nobody = Changes::default().from(scene.now);
    let unit = spec.kind == TimelineKind::Unit;
    let two = first_past(&changes.from(scene.now), &nobody, 1, (scene.now, scene.end));
    two.filter(|_| unit).map(|(at, by)| (at, by * 1_000))
}
