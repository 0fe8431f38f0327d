//! The criteria of a sleep, and the reasons of what is left out: nothing that
//! is left out could have started in a sleep.

use faregate_planner::timed::{Fate, Reason};

use crate::Effort;
use crate::candidates::{is_valid, may_start, ranges};
use crate::given::Given;
use crate::scene::block;
use crate::valid::chosen;
use crate::violation::{Rule, Violation};
use crate::world::rules;

/// Activities that are left out and have a valid start in a sleep.
pub(crate) fn check(given: &Given<'_>, effort: Effort) -> Vec<Violation> {
    let scene = given.scene;
    let candidates = given.left_out().filter(|index| {
        let manual = block(*index, scene.activity(*index)).is_some();
        let over = matches!(given.timed.rows[*index].fate, Fate::Out(Reason::HandedOver));
        !manual && !over
    });
    candidates.filter_map(|index| could_start(given, index, effort)).collect()
}

fn could_start(given: &Given<'_>, index: usize, effort: Effort) -> Option<Violation> {
    let scene = given.scene;
    let from = may_start(scene, &given.derived, index)?;
    let length = scene.activity(index).placed().get();
    let starts = starts(given, index, from, effort);
    let slots = starts.into_iter().map(|start| chosen(index, start, start + length));
    let slot = slots.into_iter().find(|slot| is_valid(scene, &given.derived, slot))?;
    Some(Violation::new(Rule::Sleep, Some(given.id(&slot)), slot.start))
}

/// Starts worth trying: where something changes, a millisecond beside that, as
/// far away as something generated is long, and a grid.
fn starts(given: &Given<'_>, index: usize, from: i64, effort: Effort) -> Vec<i64> {
    let ranges = ranges(given.scene, index, from);
    let sleeps = given.sleeps();
    let within = sleeps.iter().flat_map(|(asleep, wakeup)| {
        ranges.iter().map(move |(first, last)| (*first.max(asleep), *last.min(&(wakeup - 1))))
    });
    let within: Vec<(i64, i64)> = within.filter(|(first, last)| first <= last).collect();
    let changes = changes(given, index);
    let mut starts = Vec::new();
    for (first, last) in within {
        starts.extend([first, last]);
        starts.extend(changes.iter().filter(|at| (first..=last).contains(*at)));
        let parts = i64::from(effort.grid).max(1);
        starts.extend((1..parts).map(|part| first + (last - first) / parts * part));
    }
    starts.sort_unstable();
    starts.dedup();
    starts
}

fn changes(given: &Given<'_>, index: usize) -> Vec<i64> {
    let (scene, world) = (given.scene, &given.derived);
    let rules = rules(scene);
    let length = scene.activity(index).placed().get();
    let mut instants: Vec<i64> = world.charge.instants().chain(world.peak.instants()).collect();
    instants.push(scene.plan.handover.get());
    let gap = rules.shutdown + rules.min_sleep + rules.wakeup;
    let away = [0, rules.wakeup, rules.min_awake, gap, -length, -length - rules.shutdown];
    let all = instants.iter().flat_map(|at| away.map(|away| at + away));
    all.flat_map(|at| [at - 1, at, at + 1]).collect()
}

/// Reasons that can be told from the plan itself.
pub(crate) fn reasons(given: &Given<'_>) -> Vec<Violation> {
    let rows = given.timed.rows.iter().enumerate();
    let left_out = rows.filter_map(|(index, row)| match &row.fate {
        Fate::Out(reason) => Some((index, row.id, reason)),
        _ => None,
    });
    let wrong = left_out.filter(|(index, _, reason)| !is_true(given, *index, reason));
    wrong
        .map(|(_, id, reason)| {
            let detail = format!("{reason:?}");
            Violation::new(Rule::Reason, Some(id), given.scene.now).detail(detail)
        })
        .collect()
}

fn is_true(given: &Given<'_>, index: usize, reason: &Reason) -> bool {
    let scene = given.scene;
    let activity = scene.activity(index);
    let out = |id| given.timed.rows.iter().any(|r| r.id == id && matches!(r.fate, Fate::Out(_)));
    let depends = |id| activity.after.iter().any(|dependency| dependency.prior == id);
    let with = |id| scene.index(id).map(|index| scene.activity(index));
    match reason {
        Reason::PriorOut(id) => depends(*id) && (out(*id) || with(*id).is_none()),
        Reason::PriorEnded(id, outcome) => {
            depends(*id) && scene.ended(*id).is_some_and(|ended| ended.outcome == *outcome)
        }
        Reason::WaitsForOutcome(id) => depends(*id) && given.timed.slot(*id).is_some(),
        Reason::GroupTaken(id) => {
            let group = with(*id).and_then(|other| other.group.as_ref());
            let started = scene.ended(*id).is_some_and(|ended| ended.started.is_some());
            group.is_some()
                && group == activity.group.as_ref()
                && (started || given.timed.slot(*id).is_some())
        }
        // There would have been one if nothing depended on anything later than now.
        Reason::NoRangeLeft => {
            block(index, activity).is_some()
                || activity.after.iter().any(|d| given.timed.slot(d.prior).is_some())
                || ranges(scene, index, scene.earliest(index)).is_empty()
        }
        Reason::Committed => ranges(scene, index, scene.now)
            .first()
            .is_some_and(|(first, _)| *first < scene.earliest(index)),
        Reason::Limit { amount, .. } => *amount >= 0,
        Reason::HandedOver => true,
    }
}
