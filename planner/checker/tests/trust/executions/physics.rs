//! What can be wrong with charge, load, data, sleep and handover.

use faregate_agents::Categories;
use faregate_checker::{Rule, Violation};
use faregate_planner::Activity;
use faregate_planner::plan::Effect;
use faregate_planner::trace::{Happened, Truth};
use faregate_planner::units::{Bytes, Span};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use super::{Execution, MS};

pub(crate) fn trusts_old(e: &mut Execution) -> bool {
    e.trace.charge_holds = Some(MS);
    e.find(|activity| !activity.marginal.is_zero()).is_some()
}

/// Two with a common bit, of which the first runs on into the second.
pub(crate) fn early_in_the_way(e: &mut Execution) -> bool {
    let all = e.dispatched();
    let pairs = all.iter().flat_map(|a| all.iter().map(move |b| (a, b)));
    let mut pairs = pairs.filter(|((_, a), (_, b))| a.start < b.start && b.length() > MS);
    let Some(((first, _), (second, slot))) = pairs.next() else { return false };
    for id in [first, second] {
        e.activity(*id).resources = Categories::from_mask(1 << 101);
    }
    let dispatch = e.dispatch_of(*first);
    (dispatch.early, dispatch.ends) = (true, slot.end);
    true
}

pub(crate) fn short_sleep(e: &mut Execution) -> bool {
    let p = &mut e.world.parameters;
    p.min_sleep = Span::new(p.min_sleep.get() + 1);
    true
}

pub(crate) fn forgets_next(e: &mut Execution) -> bool {
    e.world.plan.next_plan = Some("next".into());
    true
}

pub(crate) fn hands_over_late(e: &mut Execution) -> bool {
    e.world.plan.next_plan = Some("next".into());
    let due = e.world.plan.handover.max(e.trace.begin);
    e.insert(due.after(MS), Happened::NoNextPlan("it is damaged".into()));
    true
}

/// After something was added to a timeline, a plan is made without it.
pub(crate) fn old_timelines(e: &mut Execution) -> bool {
    let adds = |activity: &Activity| {
        let mut impacts = activity.impacts.iter();
        impacts.any(|impact| matches!(impact.effect, Effect::AddAtStart(_)))
    };
    let Some((id, slot)) = e.find(adds) else { return false };
    let Happened::Planned { mut state, timed, why } = e.trace.entries[0].what.clone() else {
        return false;
    };
    let line = e.activity(id).impacts[0].timeline.clone();
    let specs = &e.world.parameters.timelines;
    let initial = specs.iter().find(|spec| spec.name == line).map(|spec| spec.initial);
    state.timelines.insert(line, initial.unwrap_or(0));
    e.insert(slot.start, Happened::Planned { state, timed, why });
    true
}

/// How things stand at the end, by what was recorded: everything sleeps.
fn at_the_end(e: &Execution) -> Truth {
    let made = e.trace.entries.iter().map(|entry| match &entry.what {
        Happened::Ended { data, .. } => data.get(),
        Happened::Window { index, open: false } => e.trace.windows[*index].data.get(),
        _ => 0,
    });
    let data = Bytes::new(made.sum());
    let (charge, none) = (charge_at_the_end(e), Milliwatts::ZERO);
    Truth { charge, load: none, peak: none, engines: 0, data }
}

/// With the load of the begin, which is all that was recorded.
fn charge_at_the_end(e: &Execution) -> Microjoules {
    let first = e.trace.entries.iter().find_map(|entry| match &entry.what {
        Happened::Truth(truth) => Some((entry.at, truth)),
        _ => None,
    });
    let (since, truth) = first.expect("there is one at the begin");
    let p = &e.world.parameters;
    let signed = |mw: Milliwatts| i128::from(mw.get());
    let net = signed(p.rtg) - signed(p.base) - signed(truth.load);
    let charge = i128::from(truth.charge.get()) + net * i128::from(e.trace.end.since(since).get());
    let charge = charge.clamp(0, e.world.state.capacity.get().into());
    Microjoules::new(u64::try_from(charge).expect("a charge"))
}

fn ends_with(e: &mut Execution, change: impl FnOnce(&mut Truth)) -> bool {
    let mut truth = at_the_end(e);
    change(&mut truth);
    e.insert(e.trace.end, Happened::Truth(truth));
    // A computer that is up until the end draws something then.
    let last = e.trace.entries.iter().rev().find_map(|entry| match entry.what {
        Happened::Mode(mode) => Some(mode),
        _ => None,
    });
    last == Some(faregate_planner::state::Mode::Asleep)
}

pub(crate) fn draws_asleep(e: &mut Execution) -> bool {
    ends_with(e, |truth| truth.load = Milliwatts::new(1))
}

pub(crate) fn finds_charge(e: &mut Execution) -> bool {
    ends_with(e, |truth| truth.charge = Microjoules::new(truth.charge.get() + 1_000_000))
}

pub(crate) fn loses_data(e: &mut Execution) -> bool {
    ends_with(e, |truth| truth.data = Bytes::new(truth.data.get() - 1))
}

#[test]
fn an_execution_that_adds_up_keeps_every_rule() {
    let mut ended = 0;
    for seed in 0..300 {
        let Some(mut execution) = super::execution(seed) else { continue };
        if ends_with(&mut execution, |_| ()) {
            let wrong = execution.wrong();
            // The load of the begin, up to the end, may be more than there is.
            let flat = |one: &Violation| one.rule == Rule::RanAtHardLimit;
            assert!(wrong.iter().all(flat), "seed {seed}: {wrong:?}");
            ended += 1;
        }
    }
    assert!(ended > 100, "{ended}");
}
