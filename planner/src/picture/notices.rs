//! What somebody who looks at the picture must not overlook: mandatory
//! activities that are left out or did not succeed, and limits that are broken.

use svg::node::element::Group;

use crate::picture::pen::{BAD, text};
use crate::picture::rows::is_mandatory;
use crate::picture::{Scene, happened};
use crate::plan::{Activity, Kind, Outcome};
use crate::timed::{Excess, Fate, Reason};
use crate::trace::Trace;
use crate::words::Words;

/// More lines than these nobody reads.
const MOST: usize = 4;
/// How high a line is.
const LINE: f64 = 16.0;

/// A line each. Of an execution it is what was not done: limits that are broken
/// are the checker's to tell.
pub(super) fn notices(scene: &Scene<'_>) -> Vec<String> {
    let words = Words::new(scene.plan, scene.parameters);
    if let Some(trace) = scene.trace {
        let names: Vec<_> = undone(scene, trace).map(|one| words.activity(one.id)).collect();
        let said = format!("mandatory and not done: {}", names.join(", "));
        return if names.is_empty() { Vec::new() } else { vec![said] };
    }
    let missed: Vec<_> = missed(scene).map(|activity| words.activity(activity.id)).collect();
    let mut all = Vec::new();
    if !missed.is_empty() {
        all.push(format!("mandatory and left out: {}", missed.join(", ")));
    }
    let alone = scene.timed.unavoidable.iter();
    all.extend(alone.map(|excess| format!("unavoidable: {}", words.excess(excess))));
    all.extend(largest(&scene.timed.excess).map(|excess| words.excess(excess)));
    let more = all.len().saturating_sub(MOST);
    if more > 0 {
        all.truncate(MOST - 1);
        all.push(format!("and {} more limits that are broken", more + 1));
    }
    all
}

/// Of each limit the largest excess: that of all that exceed it together.
fn largest(all: &[Excess]) -> impl Iterator<Item = &Excess> {
    let is_largest = move |(at, one): &(usize, &Excess)| {
        let others = all.iter().enumerate().filter(|(_, other)| other.limit == one.limit);
        others.max_by_key(|(at, other)| (other.amount, *at)).is_some_and(|(best, _)| best == *at)
    };
    all.iter().enumerate().filter(is_largest).map(|(_, one)| one)
}

/// Mandatory, left out, and nobody can say that it is not needed.
fn missed<'a>(scene: &Scene<'a>) -> impl Iterator<Item = &'a Activity> {
    let rows = scene.plan.activities.iter().zip(&scene.timed.rows);
    let parameters = scene.parameters;
    let missed = rows.filter(move |(activity, row)| match &row.fate {
        Fate::Out(Reason::GroupTaken(_) | Reason::WaitsForOutcome(_)) => false,
        Fate::Out(_) => activity.kind != Kind::Cleanup && is_mandatory(parameters, activity),
        _ => false,
    });
    missed.map(|(activity, _)| activity)
}

/// Mandatory, and it did not succeed, nor did another one of its group start.
fn undone<'a>(scene: &Scene<'a>, trace: &'a Trace) -> impl Iterator<Item = &'a Activity> {
    let Scene { plan, parameters, .. } = *scene;
    let outcome = |activity: &Activity| happened::outcome(trace, activity.id);
    let replaced = move |one: &Activity| {
        let mut others = plan.activities.iter().filter(|other| other.group == one.group);
        one.group.is_some()
            && others.any(|other| outcome(other).is_some_and(|how| how != Outcome::NotStarted))
    };
    let mandatory = plan
        .activities
        .iter()
        .filter(|one| one.kind != Kind::Cleanup && is_mandatory(parameters, one));
    mandatory.filter(move |one| match outcome(one) {
        Some(Outcome::Succeeded) => false,
        None | Some(Outcome::NotStarted) => !replaced(one),
        Some(_) => true,
    })
}

pub(super) fn height(notices: &[String]) -> f64 {
    notices.iter().map(|_| LINE).sum()
}

pub(super) fn draw(notices: &[String], (left, first): (f64, f64)) -> Group {
    let mut y = first;
    notices.iter().fold(Group::new().set("font-weight", "bold"), |group, words| {
        let line = text(left, y, words).set("fill", BAD);
        y += LINE;
        group.add(line)
    })
}
