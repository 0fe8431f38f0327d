//! When activities run: ranges, durations, dependencies, groups, and the commit
//! window.

use faregate_planner::plan::Kind;

use crate::given::Given;
use crate::scene::{How, Placed};
use crate::valid::{Priors, group_taken, priors};
use crate::violation::{Rule, Violation};

pub(crate) fn check(given: &Given<'_>) -> Vec<Violation> {
    let each = given.chosen().flat_map(|placed| {
        let judged = [range(given, placed), duration(given, placed), after(given, placed)];
        judged.into_iter().flatten().chain(ends(given, placed)).chain(group(given, placed))
    });
    each.chain(commit(given)).collect()
}

fn violation(given: &Given<'_>, rule: Rule, placed: &Placed) -> Violation {
    Violation::new(rule, Some(given.id(placed)), placed.start)
}

fn range(given: &Given<'_>, placed: &Placed) -> Option<Violation> {
    let slot = given.timed.slot(given.id(placed))?;
    let activity = given.scene.activity(placed.index);
    let broken = violation(given, Rule::Range, placed);
    let Some(range) = activity.starts.get(slot.range) else {
        return Some(broken.detail(format!("it has no range {}", slot.range)));
    };
    let early = range.from.get().max(given.scene.now) - placed.start;
    let late = placed.start - range.to.get();
    (early.max(late) > 0).then(|| broken.by(early.max(late)))
}

fn ends(given: &Given<'_>, placed: &Placed) -> Vec<Violation> {
    let Some(slot) = given.timed.slot(given.id(placed)) else { return Vec::new() };
    let range = given.scene.activity(placed.index).starts.get(slot.range);
    let cutoff = range.map(|range| (Rule::Cutoff, range.cutoff.get()));
    let limits = cutoff.into_iter().chain([(Rule::End, given.scene.end)]);
    let past = limits.filter(|(_, limit)| placed.end > *limit);
    past.map(|(rule, limit)| violation(given, rule, placed).by(placed.end - limit)).collect()
}

fn duration(given: &Given<'_>, placed: &Placed) -> Option<Violation> {
    let activity = given.scene.activity(placed.index);
    let (length, longest) = (placed.end - placed.start, activity.duration.get());
    let (rule, shortest) = match activity.kind {
        Kind::Expanding { minimum } => (Rule::Expansion, minimum.get()),
        _ => (Rule::Duration, longest),
    };
    let off = (shortest - length).max(length - longest);
    (off > 0).then(|| violation(given, rule, placed).by(off))
}

fn after(given: &Given<'_>, placed: &Placed) -> Option<Violation> {
    let broken = violation(given, Rule::Dependency, placed);
    match priors(given.scene, &given.world, placed.index) {
        // The commit window is looked at by itself.
        Priors::From(from) if from > given.scene.earliest(placed.index) => {
            (placed.start < from).then(|| broken.by(from - placed.start))
        }
        Priors::From(_) => None,
        Priors::Ended(prior, outcome) => Some(broken.detail(format!("{prior} ended: {outcome:?}"))),
        Priors::Out(prior) => Some(broken.detail(format!("{prior} is left out"))),
        Priors::Waits(prior) => Some(broken.detail(format!("{prior} has not ended"))),
    }
}

fn group(given: &Given<'_>, placed: &Placed) -> Option<Violation> {
    let taken = group_taken(given.scene, &given.world, placed.index)?;
    Some(violation(given, Rule::Group, placed).detail(taken.to_string()))
}

/// Nothing that starts in the commit window is moved, removed or inserted.
fn commit(given: &Given<'_>) -> Vec<Violation> {
    let scene = given.scene;
    let fixed = scene.fixed.iter().filter(|fixed| !matches!(fixed.how, How::Runs { .. }));
    let moved = fixed.filter(|fixed| !given.world.placed.contains(fixed)).map(|fixed| {
        let manual = matches!(fixed.how, How::Block { .. });
        let rule = if manual { Rule::Manual } else { Rule::Commit };
        violation(given, rule, fixed).detail("it was moved or removed")
    });
    let earliest = |placed: &Placed| scene.earliest(placed.index);
    let fixed = |placed: &Placed| scene.fixed.iter().any(|fixed| fixed.index == placed.index);
    let early = given.chosen().filter(|placed| placed.start < earliest(placed) && !fixed(placed));
    let inserted = early
        .filter(|placed| placed.start >= scene.now)
        .map(|placed| violation(given, Rule::Commit, placed).by(earliest(placed) - placed.start));
    moved.chain(inserted).collect()
}
