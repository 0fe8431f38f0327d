//! What the generator's activities have too seldom for executions: failures that
//! matter, cutoffs that come, variables, units.

use std::collections::BTreeSet;

use faregate_planner::plan::{Condition, Dependency, Kind, StartRange, Status, Variable};
use faregate_planner::state::State;
use faregate_planner::units::{Span, Time};
use faregate_planner::{Activity, ActivityId, Plan};
use faregate_tickets::amount::Milliwatts;

use super::world::VARIABLES;
use crate::sequences::Sequences;
use crate::throws::Throws;

/// Priorities from here on are mandatory, as the generator has it.
const MANDATORY: u32 = 128;

pub(super) fn change(plan: &mut Plan, sequences: &mut Sequences, throws: &mut Throws) {
    for activity in &mut plan.activities {
        rank(activity, throws);
        stretch(activity, throws);
        ask(activity, throws);
        command(activity, sequences, throws);
    }
    dependants_after_priors(plan);
    clean_up(plan, throws);
}

/// More of them are mandatory, and so are not aborted before their cutoff.
fn rank(activity: &mut Activity, throws: &mut Throws) {
    if activity.priority < MANDATORY && throws.chance(30) {
        activity.priority += MANDATORY;
    }
    activity.pausable |= throws.chance(20);
}

/// Some take longer; some have no time to spare.
fn stretch(activity: &mut Activity, throws: &mut Throws) {
    let times = i64::try_from(throws.number(1, 3)).unwrap_or(1);
    let longer = Span::new(activity.duration.get() * (times - 1));
    activity.duration = Span::new(activity.duration.get() * times);
    for range in &mut activity.starts {
        range.cutoff = range.cutoff.after(longer);
        if throws.chance(40) {
            range.cutoff = range.to.after(activity.duration);
        }
    }
}

fn ask(activity: &mut Activity, throws: &mut Throws) {
    if throws.chance(20) {
        let name = throws.one_of(&VARIABLES).to_owned();
        let kind = if throws.chance(50) { Variable::Acm } else { Variable::Ddi };
        activity.conditions.push(Condition { kind, name, min: 1, max: 1 });
    }
}

/// A sequence commands the units that its resource bits stand for, so that two
/// that share a unit share a bit.
fn command(activity: &mut Activity, sequences: &mut Sequences, throws: &mut Throws) {
    let has = |unit: &usize| activity.resources.mask() & (1 << *unit) != 0;
    let units = (0..Sequences::units()).filter(has).filter_map(Sequences::unit_name);
    let units: Vec<_> = units.collect();
    if !units.is_empty() && throws.chance(60) {
        let word = units.concat();
        sequences.add(&word, &units);
        activity.sequence = Some(word);
    }
}

/// The ground does not let an activity come before what it depends on.
fn dependants_after_priors(plan: &mut Plan) {
    for place in 1..plan.activities.len() {
        let (before, from) = plan.activities.split_at_mut(place);
        let Some(activity) = from.first_mut() else { continue };
        let priors: BTreeSet<_> = activity.after.iter().map(|one| one.prior).collect();
        let priors = before.iter().filter(|one| priors.contains(&one.id));
        let least = priors.map(|one| one.priority).min().unwrap_or(u32::MAX);
        activity.priority = activity.priority.min(least);
    }
}

fn clean_up(plan: &mut Plan, throws: &mut Throws) {
    let priors: Vec<_> = plan.activities.iter().filter(|_| throws.chance(25)).cloned().collect();
    let highest = plan.activities.iter().map(|one| one.id.get()).max().unwrap_or(0);
    for (number, prior) in (highest + 1..).zip(priors) {
        let Some(id) = ActivityId::new(number) else { continue };
        plan.activities.push(cleanup(id, &prior, throws));
    }
}

fn cleanup(id: ActivityId, prior: &Activity, throws: &mut Throws) -> Activity {
    let duration = throws.minutes(2, 10);
    let from = prior.starts.iter().map(|range| range.from).min().unwrap_or(Time::ZERO);
    let last = prior.starts.iter().map(|range| range.cutoff).max().unwrap_or(Time::ZERO);
    let to = last.after(throws.minutes(10, 240));
    let draw = Milliwatts::new(throws.number(0, 20) * 1_000);
    Activity {
        kind: Kind::Cleanup,
        priority: prior.priority,
        marginal: draw,
        peak: draw,
        engines: 1,
        starts: vec![StartRange { from, to, cutoff: to.after(duration) }],
        after: vec![Dependency {
            prior: prior.id,
            statuses: vec![Status::Failed, Status::Aborted],
        }],
        ..Activity::new(id, duration)
    }
}

/// Now and then the ground shuts the computer down itself: clear of windows,
/// which would need it.
pub(super) fn manual_block(plan: &mut Plan, state: &State, throws: &mut Throws) {
    if !throws.chance(12) {
        return;
    }
    let phases = [throws.seconds(60, 300), throws.seconds(60, 300)];
    let length = throws.minutes(20, 120);
    let from = throws.within(state.now.after(Span::from_mins(60)), plan.end.before(length));
    let until = from.after(length);
    let clear = state.windows.iter().all(|window| window.end <= from || until <= window.start);
    let highest = plan.activities.iter().map(|one| one.id.get()).max().unwrap_or(0);
    let Some(id) = ActivityId::new(highest + 1).filter(|_| clear) else { return };
    let [shutdown, wakeup] = phases;
    plan.activities.push(Activity {
        kind: Kind::ManualShutdown { shutdown, wakeup },
        starts: vec![StartRange { from, to: from, cutoff: until }],
        ..Activity::new(id, length)
    });
}
