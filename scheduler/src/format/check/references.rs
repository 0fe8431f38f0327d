//! Tasks and names that a schedule refers to.

use std::collections::BTreeMap;

use crate::format::check::Judge;
use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::suggest;
use crate::format::wrong::{Report, Wrong, shown};
use crate::mission::Mission;
use crate::task::{Body, BuiltIn, TaskId};

/// A number is given once.
pub(crate) fn duplicates(drafts: &[Draft], report: &mut Report<'_>) {
    let mut first: BTreeMap<TaskId, &Draft> = BTreeMap::new();
    for draft in drafts {
        let Some(id) = draft.id else { continue };
        match first.get(&id) {
            None => drop(first.insert(id, draft)),
            Some(before) => {
                let wrong = Wrong::new(Rule::Duplicate, format!("{id} is there already"))
                    .expected("a number that no other task has");
                let also = (before.span("id"), "here first".to_owned());
                report.error_with(draft.span("id"), "id", wrong, also);
            }
        }
    }
}

/// Whom a task refers to must be there.
pub(crate) fn unknown(drafts: &[Draft], judge: Judge<'_>, report: &mut Report<'_>) {
    // A number that could not be read may be the one that is missed.
    if judge.whole && drafts.iter().all(|draft| draft.id.is_some()) {
        let known: BTreeMap<TaskId, &Draft> =
            drafts.iter().filter_map(|draft| Some((draft.id?, draft))).collect();
        for draft in drafts {
            tasks(draft, &known, report);
        }
    }
    if let Some(mission) = judge.mission.filter(|_| judge.mission_good) {
        for draft in drafts {
            names(draft, mission, report);
        }
    }
}

fn tasks(draft: &Draft, known: &BTreeMap<TaskId, &Draft>, report: &mut Report<'_>) {
    let missing = |id: &TaskId| !known.contains_key(id);
    for dependency in &draft.task.after {
        if missing(&dependency.task) {
            report.error(draft.span("after"), "after", unknown_task(dependency.task));
        }
    }
    if let Some(cleanup) = draft.task.cleanup {
        match known.get(&cleanup) {
            None => report.error(draft.span("cleanup"), "cleanup", unknown_task(cleanup)),
            Some(task) => times_of_cleanup(draft, task, report),
        }
    }
    if let Body::BuiltIn(BuiltIn::Remove(gone)) = &draft.task.body {
        for id in gone.iter().copied().filter(missing) {
            let wrong = Wrong::new(Rule::NoEffect, format!("there is no {id} to remove"));
            report.warn(draft.span(draft.body), draft.body, wrong);
        }
    }
}

/// A task that is referred to, and is not there.
pub(crate) fn unknown_task(id: TaskId) -> Wrong {
    Wrong::new(Rule::UnknownTask, format!("there is no {id} in the schedule"))
        .expected("the number of a task of the schedule")
}

/// A cleanup runs when another task has failed, whatever its own times say.
fn times_of_cleanup(draft: &Draft, cleanup: &Draft, report: &mut Report<'_>) {
    let timed = cleanup.task.interval.is_some()
        || cleanup.task.windows.iter().any(|window| *window != crate::task::Window::default());
    if timed && let (Some(id), Some(for_whom)) = (cleanup.id, draft.id) {
        let message = format!("{id} cleans up after {for_whom}: its times have no effect");
        let help = "leave out st, et, window and interval of a cleanup task";
        let wrong = Wrong::new(Rule::NoEffect, message).help(help);
        report.warn(cleanup.span("st"), "st", wrong);
    }
}

fn names(draft: &Draft, mission: &Mission, report: &mut Report<'_>) {
    let gates = || mission.devices.iter().map(|device| device.name.as_str());
    for gate in draft.task.gates.iter().filter(|gate| gates().all(|known| known != **gate)) {
        let field = if draft.has("gates") && draft.good(["gates"]) { "gates" } else { "step" };
        report.error(draft.span(field), field, no_such("gate", gate, gates()));
    }
    let modes = || mission.modes.iter().map(|mode| mode.name.as_str());
    if let Body::BuiltIn(BuiltIn::EnterMode(mode) | BuiltIn::LeaveMode(mode)) = &draft.task.body
        && modes().all(|known| known != mode)
    {
        report.error(draft.span(draft.body), draft.body, no_such("mode", mode, modes()));
    }
}

/// A name that the mission does not have, and what it has.
pub(crate) fn no_such<'a>(
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> Wrong {
    let wrong = Wrong::new(Rule::UnknownName, format!("the mission has no {what} {}", shown(name)));
    let names: Vec<_> = known.clone().take(12).collect();
    let wrong = match names.as_slice() {
        [] => wrong.help(format!("the mission has no {what} at all: give the mission it is for")),
        names => wrong.expected(format!("a {what} of the mission: {}", names.join(", "))),
    };
    match suggest::nearest(name, known) {
        Some(near) => wrong.help(format!("did you mean {near}?")),
        None => wrong,
    }
}
