//! What can go wrong in an execution.

use faregate_agents::Categories;
use faregate_planner::plan::{Condition, Kind, Outcome, Variable};
use faregate_planner::state::Mode;
use faregate_planner::timed::Fate;
use faregate_planner::trace::{Cause, Entry, Happened};
use faregate_planner::units::Span;
use faregate_planner::{Activity, ActivityId};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use super::{Execution, MS};

pub(crate) fn before_its_range(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|_| true) else { return false };
    e.activity(id).starts[slot.range].from = slot.start.after(MS);
    true
}

pub(crate) fn prior_fails(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| !activity.after.is_empty()) else { return false };
    let prior = e.activity(id).after[0].prior;
    let ends = e.trace.entries.iter_mut().find_map(|entry| match &mut entry.what {
        Happened::Ended { id, outcome, .. } if *id == prior => Some(outcome),
        _ => None,
    });
    ends.map(|outcome| *outcome = Outcome::Failed).is_some()
}

pub(crate) fn cold(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| !activity.zones.is_empty()) else { return false };
    e.dispatch_of(id).zones[0].ok = false;
    true
}

pub(crate) fn truly_cold(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| !activity.zones.is_empty()) else { return false };
    let zone = &mut e.dispatch_of(id).zones[0];
    zone.truly = zone.needed - zone.margin - 1;
    true
}

pub(crate) fn unknown(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|_| true) else { return false };
    let condition = Condition { kind: Variable::Ddi, name: "arm stowed".into(), min: 1, max: 1 };
    e.activity(id).conditions.push(condition);
    true
}

pub(crate) fn goes_down(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|_| true) else { return false };
    e.insert(slot.start, Happened::Mode(Mode::ShuttingDown));
    true
}

/// Two that run at the same time.
fn together(e: &Execution) -> Option<(ActivityId, ActivityId)> {
    let all = e.dispatched();
    let pairs = all.iter().flat_map(|a| all.iter().map(move |b| (a, b)));
    let mut both = pairs.filter(|((a, x), (b, y))| a != b && x.start < y.end && y.start < x.end);
    both.next().map(|((a, _), (b, _))| (*a, *b))
}

pub(crate) fn shares_bits(e: &mut Execution) -> bool {
    let Some((a, b)) = together(e) else { return false };
    for id in [a, b] {
        e.activity(id).resources = Categories::from_mask(1 << 100);
    }
    true
}

pub(crate) fn too_many_engines(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|activity| activity.engines > 0) else { return false };
    e.world.parameters.engines = e.activity(id).engines - 1;
    true
}

pub(crate) fn too_much_peak(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|_| true) else { return false };
    let peak = e.world.parameters.peak_limit.saturating_add(Milliwatts::new(1));
    e.truth_of(slot.start, e.world.state.capacity, peak);
    true
}

pub(crate) fn past_cutoff(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|_| true) else { return false };
    e.activity(id).starts[slot.range].cutoff = slot.end.before(MS);
    true
}

pub(crate) fn below_hard(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|activity| !activity.marginal.is_zero()) else { return false };
    e.insert(slot.start, Happened::Estimate { charge: Microjoules::ZERO });
    true
}

pub(crate) fn truly_below_hard(e: &mut Execution) -> bool {
    let Some((_, slot)) = e.find(|activity| !activity.marginal.is_zero()) else { return false };
    let (lag, empty) = (Span::new(1), Microjoules::ZERO);
    e.trace.charge_lag = lag;
    e.truth_of(slot.start, empty, Milliwatts::ZERO);
    e.truth_of(slot.end, empty, Milliwatts::ZERO);
    true
}

pub(crate) fn below_soft(e: &mut Execution) -> bool {
    let from = e.world.parameters.mandatory_from;
    let optional = |a: &Activity| a.priority < from && !a.marginal.is_zero();
    let Some((_, slot)) = e.find(optional) else { return false };
    let p = &e.world.parameters;
    let between = i128::from(p.soft_min_soc.get() + p.hard_min_soc.get()) / 2;
    let charge = between * i128::from(e.world.state.capacity.get()) / 1_000_000;
    let charge = Microjoules::new(u64::try_from(charge).expect("a charge"));
    e.insert(slot.start, Happened::Estimate { charge });
    true
}

pub(crate) fn past_duration(e: &mut Execution) -> bool {
    let from = e.world.parameters.mandatory_from;
    let fixed = |a: &Activity| a.priority < from && a.kind == Kind::Generic;
    let Some((id, slot)) = e.find(fixed) else { return false };
    e.dispatch_of(id).ends = slot.end.before(MS);
    true
}

pub(crate) fn aborted_for_nothing(e: &mut Execution) -> bool {
    e.abort(Cause::Cutoff, true, true)
}

pub(crate) fn not_revoked(e: &mut Execution) -> bool {
    e.abort(Cause::Ordered, false, true)
}

pub(crate) fn not_safed(e: &mut Execution) -> bool {
    e.abort(Cause::Ordered, true, false)
}

pub(crate) fn paused(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|activity| !activity.pausable) else { return false };
    e.insert(slot.start, Happened::Paused(id));
    e.insert(slot.start, Happened::Resumed(id));
    true
}

pub(crate) fn cleans_up(e: &mut Execution) -> bool {
    let waits = |a: &Activity| !a.after.is_empty() && a.kind == Kind::Generic;
    let Some((id, _)) = e.find(waits) else { return false };
    e.activity(id).kind = Kind::Cleanup;
    true
}

pub(crate) fn two_of_a_group(e: &mut Execution) -> bool {
    let all = e.dispatched();
    for (id, _) in all.iter().take(2) {
        e.activity(*id).group = Some("one of us".into());
    }
    all.len() > 1
}

pub(crate) fn recommitted(e: &mut Execution) -> bool {
    let Happened::Planned { state, timed, why } = e.trace.entries[0].what.clone() else {
        return false;
    };
    let until = state.now.after(e.world.parameters.commit);
    let mut later = timed.clone();
    let slot = later.rows.iter_mut().find_map(|row| match &mut row.fate {
        Fate::Scheduled(slot) if slot.start < until => Some(slot),
        _ => None,
    });
    let Some(slot) = slot else { return false };
    (slot.start, slot.end) = (slot.start.after(MS), slot.end.after(MS));
    let what = Happened::Planned { state, timed: later, why };
    e.trace.entries.insert(1, Entry { at: e.trace.begin, what });
    true
}

pub(crate) fn out_of_order(e: &mut Execution) -> bool {
    let Some(last) = e.trace.entries.last_mut() else { return false };
    let before = last.at;
    last.at = e.trace.begin.before(MS);
    before > e.trace.begin
}

pub(crate) fn loses_one(e: &mut Execution) -> bool {
    let Some((id, _)) = e.find(|_| true) else { return false };
    let place = e.end_of(id);
    e.trace.entries.remove(place);
    true
}

pub(crate) fn twice(e: &mut Execution) -> bool {
    let Some((id, slot)) = e.find(|_| true) else { return false };
    let again = e.dispatch_of(id).clone();
    e.insert(slot.end, Happened::Dispatched(Box::new(again)));
    true
}
