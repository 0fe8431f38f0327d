//! Which timelines are drawn, and their limits: charge, peak power, data, and
//! those named ones that an activity of the plan touches.

use crate::parameters::{TimelineKind, TimelineSpec};
use crate::picture::Scene;
use crate::picture::panel::{Kind, Line, Panel, percent};
use crate::picture::scale::float;
use crate::plan::Plan;
use crate::timed;
use crate::trace::{Happened, Trace, Truth};
use crate::units::{Ppm, Time};
use crate::words::bytes;

pub(super) fn panels(scene: &Scene<'_>) -> Vec<Panel> {
    let named = scene.parameters.timelines.iter().filter(|spec| is_touched(scene.plan, spec));
    let own = [charge(scene), peak(scene), data(scene)];
    own.into_iter().chain(named.map(|spec| line(scene, spec))).collect()
}

fn is_touched(plan: &Plan, spec: &TimelineSpec) -> bool {
    plan.activities.iter().any(|activity| {
        let impacts = activity.impacts.iter().map(|impact| &impact.timeline);
        let asked = activity.constraints.iter().map(|asked| &asked.timeline);
        impacts.chain(asked).any(|name| *name == spec.name)
    })
}

/// A named timeline. What its values truly were nobody measures: of an execution
/// there is what was planned.
fn line(scene: &Scene<'_>, spec: &TimelineSpec) -> Panel {
    let of = |line: &&timed::Line| line.name == spec.name;
    let values = scene.projection.lines.iter().find(of);
    let points = values.map(|line| all(line, float)).unwrap_or_default();
    let limit = |name: &str, value: i64, kind| {
        let words = format!("{name} {value}");
        Line { words, value: float(value), kind }
    };
    let limits =
        vec![limit("maximum", spec.max, Kind::Above), limit("minimum", spec.min, Kind::Below)];
    let points = match scene.trace {
        None => (points, Vec::new()),
        Some(_) => (Vec::new(), points),
    };
    let (low, high) = extent(&points, &limits);
    let room = ((high - low) * 0.12).max(0.5);
    Panel {
        title: spec.name.replace('_', " "),
        unit: match spec.kind {
            TimelineKind::State => "state",
            TimelineKind::Unit => "one user at a time",
            TimelineKind::Renewable => "in use",
            TimelineKind::Consumable => "amount",
        },
        whole: true,
        height: 58.0,
        range: (low - room, high + room),
        points: points.0,
        planned: points.1,
        steps: values.is_none_or(|line| line.steps),
        limits,
    }
}

type Points = Vec<(Time, f64)>;

/// What is drawn, and what was planned where that is not the same.
fn points(
    scene: &Scene<'_>,
    name: &str,
    scaled: impl Fn(i64) -> f64,
    truly: impl Fn(&Truth) -> i64,
) -> (Points, Points) {
    let line = scene.projection.lines.iter().find(|line| line.name == name);
    let planned = line.map(|line| all(line, &scaled)).unwrap_or_default();
    match scene.trace {
        None => (planned, Vec::new()),
        Some(trace) => {
            (truths(trace).map(|(at, truth)| (at, scaled(truly(truth)))).collect(), planned)
        }
    }
}

fn all(line: &timed::Line, scaled: impl Fn(i64) -> f64) -> Points {
    line.points.iter().map(|(at, value)| (*at, scaled(*value))).collect()
}

fn truths(trace: &Trace) -> impl Iterator<Item = (Time, &Truth)> {
    trace.entries.iter().filter_map(|entry| match &entry.what {
        Happened::Truth(truth) => Some((entry.at, truth)),
        _ => None,
    })
}

fn units(amount: u64) -> i64 {
    i64::try_from(amount).unwrap_or(i64::MAX)
}

/// The smallest and the largest of them.
fn extent(points: &(Points, Points), limits: &[Line]) -> (f64, f64) {
    let values = points.0.iter().chain(&points.1).map(|(_, value)| *value);
    let values = values.chain(limits.iter().map(|limit| limit.value));
    values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)))
}

fn charge(scene: &Scene<'_>) -> Panel {
    let capacity = scene.state.capacity.get();
    let points = points(
        scene,
        "charge",
        |charge| percent(charge, capacity),
        |truth| units(truth.charge.get()),
    );
    let parameters = scene.parameters;
    let limits = [
        ("maximum", parameters.max_soc, Kind::Above),
        ("handover", scene.plan.handover_min_soc, Kind::At(scene.plan.handover)),
        ("soft minimum", parameters.soft_min_soc, Kind::Below),
        ("hard minimum", parameters.hard_min_soc, Kind::Hard),
    ];
    let limits = limits.map(|(name, ppm, kind): (_, Ppm, _)| Line {
        words: format!("{name} {ppm}"),
        value: float(ppm.get()) / 10_000.0,
        kind,
    });
    let (low, _) = extent(&points, &limits);
    Panel {
        title: "State of charge".into(),
        unit: "%",
        whole: false,
        height: 132.0,
        range: ((low / 10.0 - 0.5).floor() * 10.0, 100.0),
        points: points.0,
        planned: points.1,
        steps: false,
        limits: limits.into(),
    }
}

fn peak(scene: &Scene<'_>) -> Panel {
    let watts = |mw: i64| float(mw) / 1_000.0;
    let points = points(scene, "peak", watts, |truth| units(truth.peak.get()));
    let limit = scene.parameters.peak_limit;
    let limits = vec![Line {
        words: format!("limit {limit}"),
        value: watts(units(limit.get())),
        kind: Kind::Above,
    }];
    let (_, high) = extent(&points, &limits);
    Panel {
        title: "Peak power".into(),
        unit: "W",
        whole: false,
        height: 74.0,
        range: (0.0, (high * 1.1).max(1.0)),
        points: points.0,
        planned: points.1,
        steps: true,
        limits,
    }
}

fn data(scene: &Scene<'_>) -> Panel {
    let megabytes = |bytes: i64| float(bytes) / 1e6;
    let points = points(scene, "data", megabytes, |truth| truth.data.get());
    let limit = scene.plan.max_delta_data.get();
    let limits = vec![Line {
        words: format!("limit {}", bytes(limit)),
        value: megabytes(limit),
        kind: Kind::Above,
    }];
    let (low, high) = extent(&points, &limits);
    let (low, high) = (low.min(0.0), high.max(0.0));
    let room = ((high - low) * 0.1).max(1e-6);
    Panel {
        title: "Data on board".into(),
        unit: "MB, since the plan's begin",
        whole: false,
        height: 74.0,
        range: (if low < 0.0 { low - room } else { 0.0 }, high + room),
        points: points.0,
        planned: points.1,
        steps: true,
        limits,
    }
}
