//! What must hold of a plan, parameters and a state before anything is planned
//! from them.

use std::collections::BTreeSet;

use faregate_tickets::amount::Milliwatts;

use crate::parameters::{Parameters, Zone};
use crate::plan::{Activity, Kind, Plan};
use crate::problem::Unfit;
use crate::state::State;

use super::items::{blocks, index};
use super::{FAR, Index, LARGE};

pub(super) fn all(plan: &Plan, parameters: &Parameters, state: &State) -> Vec<Unfit> {
    let mut unfit = Vec::new();
    numbers(plan, parameters, state, &mut unfit);
    let index = index(plan);
    let mut seen = BTreeSet::new();
    for activity in &plan.activities {
        if !seen.insert(activity.id) {
            unfit.push(Unfit::Twice(activity.id));
        }
        one(activity, &index, parameters, &mut unfit);
    }
    states(&index, state, &mut unfit);
    if unfit.is_empty() {
        overlapping(plan, state, &mut unfit);
        sums(plan, parameters, state, &mut unfit);
    }
    unfit
}

fn one(activity: &Activity, index: &Index, parameters: &Parameters, unfit: &mut Vec<Unfit>) {
    let id = activity.id;
    if activity.starts.is_empty() {
        unfit.push(Unfit::NoStart(id));
    }
    let (shortest, longest) = (activity.placed().get(), activity.duration.get());
    if shortest < 0 || longest < shortest || longest > FAR {
        unfit.push(Unfit::Duration(id));
    }
    let unknown = activity.after.iter().filter(|on| !index.contains_key(&on.prior));
    unfit.extend(unknown.map(|on| Unfit::Prior(id, on.prior)));
    let known = |name: &String| parameters.zones.iter().any(|zone| zone.name == *name);
    let zones = activity.zones.iter().filter(|name| !known(name));
    unfit.extend(zones.map(|zone| Unfit::Zone(id, zone.clone())));
    let known = |name: &String| parameters.timelines.iter().any(|line| line.name == *name);
    let impacts = activity.impacts.iter().map(|impact| &impact.timeline);
    let named = impacts.chain(activity.constraints.iter().map(|constraint| &constraint.timeline));
    unfit.extend(named.filter(|name| !known(name)).map(|name| Unfit::Timeline(id, name.clone())));
    if let Kind::ManualShutdown { shutdown, wakeup } = activity.kind {
        let both = shutdown.get().checked_add(wakeup.get());
        let fits = both.is_some_and(|both| both <= longest);
        if shutdown.get() < 0 || wakeup.get() < 0 || !fits {
            unfit.push(Unfit::Block(id));
        }
    }
}

fn states(index: &Index, state: &State, unfit: &mut Vec<Unfit>) {
    let mut seen = BTreeSet::new();
    let ended = state.ended.iter().map(|ended| ended.id);
    for id in ended.chain(state.running.iter().map(|running| running.id)) {
        if !seen.insert(id) {
            unfit.push(Unfit::TwoStates(id));
        }
    }
    let strange = state.running.iter().filter(|running| !index.contains_key(&running.id));
    unfit.extend(strange.map(|running| Unfit::Running(running.id)));
}

fn overlapping(plan: &Plan, state: &State, unfit: &mut Vec<Unfit>) {
    let who = |from: i64, not: Option<crate::ActivityId>| {
        let at = |activity: &&Activity| {
            matches!(activity.kind, Kind::ManualShutdown { .. })
                && Some(activity.id) != not
                && activity.starts.first().is_some_and(|range| range.from.get() == from)
        };
        plan.activities.iter().find(at).map(|activity| activity.id)
    };
    for pair in blocks(plan, state).windows(2) {
        if let [one, other] = pair
            && other.from < one.to
            && let Some(first) = who(one.from, None)
            && let Some(second) = who(other.from, Some(first))
        {
            unfit.push(Unfit::Blocks(first, second));
        }
    }
}

fn numbers(plan: &Plan, parameters: &Parameters, state: &State, unfit: &mut Vec<Unfit>) {
    let near = |at: i64| (-FAR..=FAR).contains(&at);
    let mut check = |holds: bool, what| {
        if !holds {
            unfit.push(Unfit::OutOfBounds(what));
        }
    };
    check(near(plan.end.get()), "the plan's end");
    check(near(plan.handover.get()), "the handover");
    check(near(state.now.get()), "now");
    check(near(state.mode_since.get()), "the instant since which the computer's mode is");
    check(state.mode_since <= state.now, "the computer's mode, which begins after now");
    let spans = [
        (parameters.wakeup.duration, "the wakeup"),
        (parameters.shutdown.duration, "the shutdown"),
        (parameters.min_awake, "the minimum awake time"),
        (parameters.min_sleep, "the minimum sleep"),
        (parameters.commit, "the commit window"),
    ];
    for (span, what) in spans {
        check((0..=FAR).contains(&span.get()), what);
    }
    let fractions = [
        (plan.handover_min_soc, "the minimum at handover"),
        (parameters.soft_min_soc, "the soft minimum"),
        (parameters.max_soc, "the maximum state of charge"),
    ];
    for (fraction, what) in fractions {
        check((0..=1_000_000).contains(&fraction.get()), what);
    }
    let day = parameters.day.length.get();
    check((1..=FAR).contains(&day), "the day's length");
    check(near(parameters.day.midnight.get()), "midnight");
    check(state.windows.iter().all(|it| it.start <= it.end), "a communication window's end");
    let instants = state.windows.iter().flat_map(|window| [window.start, window.end]);
    let running = state.running.iter().flat_map(|running| [running.started, running.ends]);
    let ended =
        state.ended.iter().flat_map(|ended| [ended.started.unwrap_or(ended.ended), ended.ended]);
    let all = instants.chain(running).chain(ended).chain(state.heating.values().copied());
    check(all.map(crate::units::Time::get).all(near), "an instant of the state");
    if (1..=FAR).contains(&day) {
        let bad = parameters.zones.iter().filter(|zone| !in_order(zone, day));
        unfit.extend(bad.map(|zone| Unfit::Table(zone.name.clone())));
    }
}

fn in_order(zone: &Zone, day: i64) -> bool {
    let rows = &zone.table;
    rows.first().is_none_or(|row| row.from.get() == 0)
        && rows.windows(2).all(|pair| pair[0].from < pair[1].from)
        && rows.iter().all(|row| {
            (0..day).contains(&row.from.get()) && (0..=FAR).contains(&row.duration.get())
        })
}

/// Everything at once, all the time, must be far from overflowing.
fn sums(plan: &Plan, parameters: &Parameters, state: &State, unfit: &mut Vec<Unfit>) {
    let wide = |power: Milliwatts| i128::from(power.get());
    let loads = [parameters.awake, parameters.wakeup.load, parameters.shutdown.load];
    let loads = || loads.iter().chain(parameters.zones.iter().map(|zone| &zone.load));
    let own = |activity: &Activity| (activity.duration.get(), activity.marginal, activity.peak);
    let window = |it: &crate::state::Window| (it.end.since(it.start).get(), it.marginal, it.peak);
    let again = parameters.commit.get().max(1_000);
    let late = |it: &crate::state::Running| it.ends.since(it.started).get().max(0) + again;
    let late: i128 = state.running.iter().map(|running| i128::from(late(running))).sum();
    let claims = || plan.activities.iter().map(own).chain(state.windows.iter().map(window));

    let peaks: i128 = loads().map(|load| wide(load.peak)).sum::<i128>()
        + claims().map(|(_, _, peak)| wide(peak)).sum::<i128>();
    let all: i128 = claims().map(|(_, marginal, _)| wide(marginal)).sum();
    let always: i128 = loads().map(|load| wide(load.marginal)).sum::<i128>()
        + wide(parameters.rtg)
        + wide(parameters.base);
    let length = i128::from(plan.end.get().max(state.now.get()) - state.now.get());
    let length = length + i128::from(parameters.min_sleep.get());
    let some: i128 = claims().map(|(span, marginal, _)| i128::from(span) * wide(marginal)).sum();
    let energy = always * length + some + all * late + i128::from(state.capacity.get());
    if peaks > LARGE.into() || i128::from(parameters.peak_limit.get()) > LARGE.into() {
        unfit.push(Unfit::TooLarge("powers"));
    }
    if energy > LARGE.into() || i128::from(state.charge.get()) > LARGE.into() {
        unfit.push(Unfit::TooLarge("energy"));
    }
    let data = plan.activities.iter().map(|activity| activity.data);
    let data = data.chain(state.windows.iter().map(|window| window.data));
    let data = data.chain(state.ended.iter().map(|ended| ended.data));
    let data = data.chain(state.running.iter().map(|running| running.data));
    let data: i128 = data.map(|data| i128::from(data.get()).abs()).sum();
    if data + i128::from(plan.max_delta_data.get()).abs() > LARGE.into() {
        unfit.push(Unfit::TooLarge("data volumes"));
    }
}
