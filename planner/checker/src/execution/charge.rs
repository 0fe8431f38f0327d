//! The charge: what it was told, and what it truly was.

use std::collections::BTreeMap;

use faregate_planner::plan::{Activity, ActivityId};
use faregate_planner::trace::{Happened, Trace};
use faregate_planner::units::Ppm;
use faregate_planner::{Parameters, Plan};

use crate::violation::{Rule, Violation};

/// What the battery can hold, as the first plan was told.
pub(super) fn capacity(trace: &Trace) -> Option<i128> {
    trace.entries.iter().find_map(|entry| match &entry.what {
        Happened::Planned { state, .. } => Some(i128::from(state.capacity.get())),
        _ => None,
    })
}

/// Nothing that draws power runs on below the hard limit; nothing optional that
/// does runs on below the soft one.
pub(super) fn check(plan: &Plan, parameters: &Parameters, trace: &Trace) -> Vec<Violation> {
    let Some(capacity) = capacity(trace) else { return Vec::new() };
    let least = |ppm: Ppm| i128::from(ppm.get()) * capacity / 1_000_000;
    let hard = told_below(trace, least(parameters.hard_min_soc), 1);
    let soft = told_below(trace, least(parameters.soft_min_soc), parameters.soft_samples.max(1));
    let truly = truly_below(parameters, trace, capacity, least(parameters.hard_min_soc));
    let mut wrong = Vec::new();
    for Worked { id, activity, from, to } in worked(plan, trace) {
        if activity.marginal.is_zero() {
            continue;
        }
        let optional = activity.priority < parameters.mandatory_from;
        let on = |stretches: &[(i64, i64)]| {
            let met = stretches.iter().map(|(start, end)| ((*start).max(from), (*end).min(to)));
            met.into_iter().find(|(start, end)| start < end)
        };
        let told = on(&hard).map(|met| (Rule::RanAtHardLimit, met, "by estimate"));
        let truly = on(&truly).map(|met| (Rule::RanAtHardLimit, met, "in truth"));
        let below =
            on(&soft).filter(|_| optional).map(|met| (Rule::RanBelowSoft, met, "by estimate"));
        for (rule, (start, end), detail) in told.or(truly).into_iter().chain(below) {
            let detail = format!("for {} ms, {detail}", end - start);
            wrong.push(Violation::new(rule, Some(id), start).detail(detail));
        }
    }
    wrong
}

/// A time in which an activity ran, and was not paused.
struct Worked<'a> {
    id: ActivityId,
    activity: &'a Activity,
    from: i64,
    to: i64,
}

fn worked<'a>(plan: &'a Plan, trace: &'a Trace) -> Vec<Worked<'a>> {
    let mut plan = plan;
    let mut since: BTreeMap<ActivityId, i64> = BTreeMap::new();
    let mut all: Vec<(&Plan, ActivityId, i64, i64)> = Vec::new();
    if let Some(Happened::Planned { state, .. }) = trace.entries.first().map(|e| &e.what) {
        let running = state.running.iter().filter(|running| running.paused.is_none());
        since.extend(running.map(|running| (running.id, state.now.get())));
    }
    for entry in &trace.entries {
        let at = entry.at.get();
        match &entry.what {
            Happened::Dispatched(dispatch) => {
                since.insert(dispatch.id, at);
            }
            Happened::Resumed(id) => {
                since.insert(*id, at);
            }
            Happened::Ended { id, .. } | Happened::Aborted { id, .. } | Happened::Paused(id) => {
                all.extend(since.remove(id).map(|from| (plan, *id, from, at)));
            }
            // It has the definitions of what runs.
            Happened::HandedOver(next) => plan = next,
            _ => {}
        }
    }
    let end = trace.end.get();
    all.extend(since.into_iter().map(|(id, from)| (plan, id, from, end)));
    let known = all.into_iter().filter_map(|(plan, id, from, to)| {
        let activity = plan.activities.iter().find(|activity| activity.id == id)?;
        Some(Worked { id, activity, from, to })
    });
    known.collect()
}

/// From when to when the last `samples` estimates were below `least`.
fn told_below(trace: &Trace, least: i128, samples: u32) -> Vec<(i64, i64)> {
    let mut stretches = Vec::new();
    let (mut row, mut since) = (0, None);
    for entry in &trace.entries {
        let Happened::Estimate { charge } = &entry.what else { continue };
        row = if i128::from(charge.get()) < least { row + 1 } else { 0 };
        if row == 0 {
            stretches.extend(since.take().map(|since| (since, entry.at.get())));
        } else if row >= samples {
            since.get_or_insert(entry.at.get());
        }
    }
    stretches.extend(since.map(|since| (since, trace.end.get())));
    stretches
}

/// From when to when the true charge was below `least` by more than its
/// estimate can be wrong: each begins later by the time that an estimate takes.
fn truly_below(
    parameters: &Parameters,
    trace: &Trace,
    capacity: i128,
    least: i128,
) -> Vec<(i64, i64)> {
    let least = least - i128::from(trace.charge_noise.get());
    let truths = points(parameters, trace, capacity);
    let mut stretches: Vec<(i64, i64)> = Vec::new();
    for pair in truths.windows(2) {
        let Some((from, to)) = below(pair[0], pair[1], least) else { continue };
        match stretches.last_mut() {
            Some(last) if last.1 >= from => last.1 = to,
            _ => stretches.push((from, to)),
        }
    }
    let lag = trace.charge_lag.get();
    let late = stretches.into_iter().map(|(from, to)| (from + lag, to));
    late.filter(|(from, to)| from < to).collect()
}

/// The true charge: straight lines between these. It is told where loads change;
/// where something is lost at once, and where it is full or flat, it is worked
/// out.
fn points(parameters: &Parameters, trace: &Trace, capacity: i128) -> Vec<(i64, i128)> {
    let [rtg, base] = [parameters.rtg, parameters.base].map(|w| i128::from(w.get()));
    let mut points: Vec<(i64, i128)> = Vec::new();
    let mut net = 0;
    for entry in &trace.entries {
        let at = entry.at.get();
        let (lost, told) = match &entry.what {
            Happened::Truth(truth) => (0, Some(truth)),
            Happened::Lost(energy) => (i128::from(energy.get()), None),
            _ => continue,
        };
        if let Some((since, charge)) = points.last().copied() {
            let free = charge + net * i128::from(at - since);
            let held = free.clamp(0, capacity);
            if free != held {
                let ms = i64::try_from((held - charge) / net).unwrap_or(0);
                points.push((since + ms, held));
            }
            points.push((at, held));
            if told.is_none() {
                points.push((at, (held - lost).max(0)));
            }
        }
        if let Some(truth) = told {
            net = rtg - base - i128::from(truth.load.get());
            points.push((at, i128::from(truth.charge.get())));
        }
    }
    points
}

/// Where a straight line between two points is below `least`: the instants are
/// rounded so that it is.
fn below((t0, c0): (i64, i128), (t1, c1): (i64, i128), least: i128) -> Option<(i64, i64)> {
    let crossing = |from: i128, to: i128| {
        let part = (least - from) * i128::from(t1 - t0) / (to - from);
        i64::try_from(part).ok().map(|part| t0 + part)
    };
    match (c0 < least, c1 < least) {
        (false, false) => None,
        (true, true) => Some((t0, t1)),
        (false, true) => Some((crossing(c0, c1)? + 1, t1)),
        (true, false) => Some((t0, crossing(c0, c1)?)),
    }
}
