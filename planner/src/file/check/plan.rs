//! A whole plan.

use std::collections::BTreeMap;

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::Report;

use crate::file::check::{About, activity, clean, dependencies, overflow};
use crate::file::names::Names;
use crate::file::read::{Placed, PlanPlaces};
use crate::plan::{Activity, Kind, Plan};
use crate::units::Time;

/// What the plan is judged by, beside itself.
pub(super) type Placement<'e> = Placed<'e, Plan, PlanPlaces<'e>>;

pub(in crate::file) fn plan(plan: &Placement<'_>, names: &Names<'_>, report: &mut Report<'_>) {
    let before = report.found.len();
    let mut about = About::new(plan.root, "the plan".into(), report);
    if plan.good && plan.value.handover > plan.value.end {
        let message = "the next plan takes over after the end of this one";
        about.error("handover", Rule::Limits, message, "not after end");
    }
    for (one, element) in plan.value.activities.iter().zip(&plan.places.activities) {
        let mut about = About::new(element, one.id.to_string(), report);
        activity::activity(one, plan.good.then_some(&plan.value), names, &mut about);
    }
    dependencies::dependencies(plan, report);
    groups(plan, report);
    blocks(plan, report);
    if clean(report, before) {
        overflow::plan(plan, report);
    }
}

/// A group of one selects nothing.
fn groups(plan: &Placement<'_>, report: &mut Report<'_>) {
    // Members that could not be read count, too: they are not missed here.
    let mut members: BTreeMap<&str, usize> = BTreeMap::new();
    for element in plan.places.all() {
        if let Some(group) = element.attribute("group") {
            *members.entry(&group.value).or_default() += 1;
        }
    }
    for (one, element) in plan.value.activities.iter().zip(&plan.places.activities) {
        let alone = |group: &String| members.get(group.as_str()).is_none_or(|count| *count < 2);
        if let Some(group) = &one.group
            && plan.places.whole()
            && alone(group)
        {
            let message = format!("it is the only member of the group {group}");
            let mut about = About::new(element, one.id.to_string(), report);
            about.warn("group", Rule::NoEffect, &message, None);
        }
    }
}

/// Manual shutdowns, each as one block, none of which overlap.
fn blocks(plan: &Placement<'_>, report: &mut Report<'_>) {
    let manual = |one: &&Activity| matches!(one.kind, Kind::ManualShutdown { .. });
    let mut blocks: Vec<_> = plan.value.activities.iter().filter(manual).collect();
    blocks.sort_by_key(|one| block(one).map(|(from, _)| from));
    for pair in blocks.windows(2) {
        let [first, second] = pair else { continue };
        let (Some((_, end)), Some((start, _))) = (block(first), block(second)) else { continue };
        if start < end
            && let Some(element) = plan.places.known.get(&second.id)
        {
            let message = format!("it begins within the manual shutdown of {}", first.id);
            let mut about = About::new(element, second.id.to_string(), report);
            let begin = element.nth("start", 0);
            about.error_at(begin, "from", Rule::Window, &message, "one after the other");
        }
    }
}

/// From when to when a manual shutdown lasts.
pub(super) fn block(activity: &Activity) -> Option<(Time, Time)> {
    let from = activity.starts.first()?.from;
    Some((from, from.after(activity.duration)))
}
