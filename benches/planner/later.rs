//! A world some time later: what was planned was executed, and one activity has
//! just ended early.

use faregate_planner::generate::World;
use faregate_planner::plan::{ActivityId, Outcome, Plan};
use faregate_planner::state::{Ended, Mode, Running};
use faregate_planner::timed::{Fate, Line, Slot, TimedPlan};
use faregate_planner::units::{Span, Time};
use faregate_planner::{State, project};
use faregate_tickets::amount::Microjoules;

use crate::support::Failure;

/// One of the first tenth that does nothing to named timelines: its early end
/// leaves their values as they were planned.
pub(crate) fn early_one(plan: &Plan, timed: &TimedPlan) -> Option<(ActivityId, Slot)> {
    let is_plain = |id| {
        let one = plan.activities.iter().find(|one| one.id == id);
        one.is_some_and(|one| one.impacts.is_empty() && one.constraints.is_empty())
    };
    let mut slots: Vec<_> = slots(timed).collect();
    slots.sort_unstable_by_key(|(id, slot)| (slot.start, *id));
    let tenth = slots.len() / 10;
    slots[..tenth].iter().rev().copied().find(|(id, _)| is_plain(*id))
}

fn slots(timed: &TimedPlan) -> impl Iterator<Item = (ActivityId, Slot)> {
    timed.rows.iter().filter_map(|row| match row.fate {
        Fate::Scheduled(slot) => Some((row.id, slot)),
        _ => None,
    })
}

/// The world in which that one has ended when half of its time was over.
pub(crate) fn later(
    world: &World,
    timed: &TimedPlan,
    (early, slot): (ActivityId, Slot),
) -> Result<World, Failure> {
    let World { plan, parameters, state } = world;
    let now = slot.start.after(Span::new(slot.length().get() / 2));
    let lines = project(plan, parameters, state, timed)?.lines;
    let line = |name: &str| lines.iter().find(|line| line.name == name);
    let charge = line("charge").map_or(0, |line| value(line, now));
    let names = parameters.timelines.iter().map(|spec| spec.name.clone());
    let named = names.filter_map(|name| Some((name.clone(), value(line(&name)?, now))));
    let (mode, mode_since) = mode(timed, state, now);
    let mut later = State {
        now,
        mode,
        mode_since,
        charge: Microjoules::new(charge.unsigned_abs()),
        timelines: named.collect(),
        ..state.clone()
    };
    let heats = timed.preheats.iter().filter(|heat| heat.start <= now && now < heat.end);
    later.heating = heats.map(|heat| (heat.zone.clone(), heat.start)).collect();
    for (id, slot) in slots(timed).filter(|(_, slot)| slot.start <= now) {
        let one = plan.activities.iter().find(|one| one.id == id).ok_or("an unknown activity")?;
        let over = id == early || slot.end <= now;
        let started = slot.start;
        if over {
            let (outcome, ended) = (Outcome::Succeeded, slot.end.min(now));
            later.ended.push(Ended { id, outcome, started: Some(started), ended, data: one.data });
        } else {
            let cutoff = one.starts.get(slot.range).map_or(slot.end, |range| range.cutoff);
            let (ends, data) = (slot.end, one.data);
            later.running.push(Running { id, started, ends, cutoff, paused: None, data });
        }
    }
    Ok(World { plan: plan.clone(), parameters: parameters.clone(), state: later })
}

/// What a line says at an instant.
fn value(line: &Line, at: Time) -> i64 {
    let next = line.points.partition_point(|(from, _)| *from <= at);
    let Some(&(from, before)) = next.checked_sub(1).and_then(|last| line.points.get(last)) else {
        return 0;
    };
    match line.points.get(next) {
        Some(&(to, after)) if !line.steps => {
            let (past, whole) = (at.since(from).get(), to.since(from).get());
            before + (after - before) / whole * past
        }
        _ => before,
    }
}

fn mode(timed: &TimedPlan, state: &State, now: Time) -> (Mode, Time) {
    let begun = timed.awake.iter().rfind(|phase| phase.wakeup <= now);
    let Some(phase) = begun else { return (state.mode, state.mode_since) };
    let begins = [
        (Mode::Asleep, phase.asleep),
        (Mode::ShuttingDown, phase.down),
        (Mode::Awake, phase.up),
        (Mode::WakingUp, phase.wakeup),
    ];
    begins.into_iter().find(|(_, from)| *from <= now).unwrap_or((state.mode, state.mode_since))
}
