//! What is shared beside power: data, sequence engines, and timelines that the
//! parameters name.

use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::plan::Effect;

use crate::flow::Curve;
use crate::scene::{How, Placed, Scene};
use crate::steps::{Changes, Steps};

/// The data on board since the plan's begin, from now on.
pub(crate) fn data(scene: &Scene<'_>, placed: &[Placed]) -> Steps {
    let mut changes = Changes::default();
    let now = scene.now;
    for ended in &scene.state.ended {
        changes.add(now, i128::from(ended.data.get()));
    }
    for running in &scene.state.running {
        let modelled = scene.index(running.id).map_or(0, |i| scene.activity(i).data.get());
        let known = i128::from(running.data.get().max(modelled));
        changes.add(now, known);
        // What is to be sent is gone when it ends.
        let own = placed.iter().find(|placed| scene.activity(placed.index).id == running.id);
        if let Some(own) = own.filter(|_| modelled < 0) {
            changes.add(own.end.max(now), i128::from(modelled) - known);
        }
    }
    let placed = placed.iter().filter(|placed| !matches!(placed.how, How::Runs { .. }));
    let claims = placed.map(|p| (p.start, p.end, scene.activity(p.index).data.get()));
    // Those that are over have sent what they say.
    let windows = scene.state.windows.iter();
    let windows = windows.map(|w| (w.start.get(), w.end.get(), w.data.get()));
    for (start, end, amount) in claims.chain(windows) {
        let at = if amount < 0 { end } else { start };
        changes.add(at.max(now), i128::from(amount));
    }
    changes.from(now)
}

/// Sequence engines in use.
pub(crate) fn engines(scene: &Scene<'_>, placed: &[Placed]) -> Steps {
    let mut changes = Changes::default();
    for placed in placed {
        let engines = i128::from(scene.activity(placed.index).engines);
        changes.add_over(placed.start, placed.end, engines);
    }
    for window in &scene.state.windows {
        let engines = i128::from(window.engines);
        changes.add_over(window.start.get(), window.end.get(), engines);
    }
    changes.from(scene.now)
}

/// What a timeline does at an instant. Ends come before starts, then the plan's
/// order decides, then the order in the activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Event {
    at: i64,
    starts: bool,
    index: usize,
    place: usize,
    change: Change,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    Set(i128),
    Add(i128),
    Rate(i128),
}

/// The values of a named timeline, a thousand times: rates are for each second.
pub(crate) fn named(scene: &Scene<'_>, placed: &[Placed], spec: &TimelineSpec) -> Curve {
    let mut events: Vec<Event> = placed.iter().flat_map(|p| events(scene, p, spec)).collect();
    events.sort_unstable();
    let now = scene.now;
    let known = scene.state.timelines.get(&spec.name).copied();
    let held: i64 = placed.iter().filter(|p| begun(scene, p)).map(|p| held(scene, p, spec)).sum();
    let mut value = i128::from(known.unwrap_or_else(|| spec.initial + held)) * 1_000;
    let mut knots = vec![(now, value, 0)];
    let (mut at, mut rate) = (now, 0);
    for event in events {
        value += rate * i128::from(event.at - at);
        at = event.at;
        match event.change {
            Change::Set(to) => value = to * 1_000,
            Change::Add(amount) => value += amount * 1_000,
            Change::Rate(more) => rate += more,
        }
        knots.push((at, value, rate));
    }
    Curve::of(knots)
}

/// Whether it began before now, so that the state has in it what it did then.
fn begun(scene: &Scene<'_>, placed: &Placed) -> bool {
    matches!(placed.how, How::Runs { .. }) || placed.start < scene.now
}

fn held(scene: &Scene<'_>, placed: &Placed, spec: &TimelineSpec) -> i64 {
    let impacts = scene.activity(placed.index).impacts.iter();
    let ours = impacts.filter(|impact| impact.timeline == spec.name);
    ours.map(|impact| if let Effect::Hold(amount) = impact.effect { amount } else { 0 }).sum()
}

fn events(scene: &Scene<'_>, placed: &Placed, spec: &TimelineSpec) -> Vec<Event> {
    let begun = begun(scene, placed);
    let paused = placed.how == How::Runs { paused: true };
    let impacts = scene.activity(placed.index).impacts.iter().enumerate();
    let ours = impacts.filter(|(_, impact)| impact.timeline == spec.name);
    let (start, end) = (placed.start.max(scene.now), placed.end);
    let mut all = Vec::new();
    for (place, impact) in ours {
        let mut push = |starts: bool, change| {
            let at = if starts { start } else { end };
            all.push(Event { at, starts, index: placed.index, place, change });
        };
        match impact.effect {
            Effect::SetAtStart(_) | Effect::AddAtStart(_) if begun => {}
            Effect::SetAtStart(value) => push(true, Change::Set(value.into())),
            Effect::SetAtEnd(value) => push(false, Change::Set(value.into())),
            Effect::AddAtStart(amount) => push(true, Change::Add(amount.into())),
            Effect::AddAtEnd(amount) => push(false, Change::Add(amount.into())),
            Effect::Hold(amount) => {
                if !begun {
                    push(true, Change::Add(amount.into()));
                }
                push(false, Change::Add(-i128::from(amount)));
            }
            Effect::Rate(_) if paused => {}
            Effect::Rate(rate) => {
                push(true, Change::Rate(rate.into()));
                push(false, Change::Rate(-i128::from(rate)));
            }
        }
    }
    all
}

/// Two that hold the same unit at a time: the later one's start.
pub(crate) fn both_hold(
    scene: &Scene<'_>,
    a: &Placed,
    b: &Placed,
    spec: &TimelineSpec,
) -> Option<i64> {
    let holds = |placed: &Placed| {
        let impacts = &scene.activity(placed.index).impacts;
        impacts.iter().any(|i| i.timeline == spec.name && matches!(i.effect, Effect::Hold(_)))
    };
    let unit = spec.kind == TimelineKind::Unit;
    (unit && holds(a) && holds(b)).then(|| overlap((a.start, a.end), (b.start, b.end))).flatten()
}

/// Where two half-open intervals begin to overlap, if they do.
pub(crate) fn overlap(a: (i64, i64), b: (i64, i64)) -> Option<i64> {
    let start = a.0.max(b.0);
    (start < a.1.min(b.1)).then_some(start)
}
