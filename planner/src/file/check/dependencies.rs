//! Activities that depend on others.

use std::collections::BTreeMap;

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::Report;

use crate::file::check::About;
use crate::file::check::plan::Placement;
use crate::plan::{Activity, ActivityId, Dependency, Status};

/// Each activity with its place in the file's order.
type Index<'p> = BTreeMap<ActivityId, (usize, &'p Activity)>;

pub(super) fn dependencies(plan: &Placement<'_>, report: &mut Report<'_>) {
    let activities = plan.value.activities.iter().enumerate();
    let index: Index<'_> = activities.clone().map(|(at, one)| (one.id, (at, one))).collect();
    for ((at, one), element) in activities.zip(&plan.places.activities) {
        let mut about = About::new(element, one.id.to_string(), report);
        for (number, after) in one.after.iter().enumerate() {
            if plan.places.known.contains_key(&after.prior) {
                importance(at, one, (number, after), &index, &mut about);
            } else if plan.places.whole() {
                let message = format!("there is no {}", after.prior);
                let place = about.element.nth("after", number);
                let expected = "the number of an activity in the plan";
                about.error_at(place, "activity", Rule::UnknownActivity, &message, expected);
            }
        }
    }
    circles(plan, &index, report);
}

/// The planner never re-orders: what waits for a less important one is tried
/// before that is placed, and gets what everything else leaves.
fn importance(
    at: usize,
    one: &Activity,
    (number, after): (usize, &Dependency),
    index: &Index<'_>,
    about: &mut About<'_, '_, '_>,
) {
    let planned = |status: &Status| matches!(status, Status::Succeeded | Status::Completed);
    let Some((prior_at, prior)) = index.get(&after.prior) else { return };
    let before = one.priority > prior.priority || one.priority == prior.priority && at < *prior_at;
    if before && one.id != prior.id && after.statuses.iter().any(planned) {
        let message = format!(
            "it is tried before {}, which it depends on: priority {} and {}",
            prior.id, one.priority, prior.priority
        );
        let help = "give the one that comes first the larger priority";
        let place = about.element.nth("after", number);
        about.warn_at(place, "activity", Rule::Importance, &message, Some(help.into()));
    }
}

/// Tells of one circle for each group of activities that wait for each other.
fn circles(plan: &Placement<'_>, index: &Index<'_>, report: &mut Report<'_>) {
    let stuck = stuck(index);
    let mut told: Vec<ActivityId> = Vec::new();
    for start in stuck.keys().copied() {
        let mut path: Vec<ActivityId> = Vec::new();
        let mut here = Some(start);
        while let Some(id) = here
            && !told.contains(&id)
            && !path.contains(&id)
        {
            path.push(id);
            here = stuck.get(&id).copied();
        }
        let circle = path.iter().position(|id| Some(*id) == here).and_then(|at| path.get(at..));
        if let Some(circle) = circle {
            tell(plan, circle, report);
        }
        told.extend(path);
    }
}

/// Activities that can never have all their priors behind them, each with one
/// of these: what remains when those without priors are taken away, again and
/// again.
fn stuck(index: &Index<'_>) -> BTreeMap<ActivityId, ActivityId> {
    let mut left: BTreeMap<ActivityId, Vec<ActivityId>> = (index.iter())
        .map(|(id, (_, one))| {
            let priors = one.after.iter().map(|after| after.prior);
            (*id, priors.filter(|prior| index.contains_key(prior)).collect())
        })
        .collect();
    loop {
        let free: Vec<ActivityId> =
            left.iter().filter(|(_, priors)| priors.is_empty()).map(|(id, _)| *id).collect();
        if free.is_empty() {
            break;
        }
        for id in &free {
            left.remove(id);
        }
        for priors in left.values_mut() {
            priors.retain(|prior| free.binary_search(prior).is_err());
        }
    }
    left.into_iter().filter_map(|(id, priors)| Some((id, priors.first().copied()?))).collect()
}

fn tell(plan: &Placement<'_>, circle: &[ActivityId], report: &mut Report<'_>) {
    let Some(first) = circle.first() else { return };
    let Some(element) = plan.places.known.get(first) else { return };
    let around = circle.iter().skip(1).chain([first]).take(8);
    let names: Vec<_> = around.map(ToString::to_string).collect();
    let message = format!("it waits for {}", names.join(", which waits for "));
    let mut about = About::new(element, first.to_string(), report);
    let place = element.nth("after", 0);
    about.error_at(place, "activity", Rule::Cycle, &message, "no circle");
}
