//! The words for kinds, statuses and modes.

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Wrong, nearest, shown};

use crate::parameters::TimelineKind;
use crate::plan::{Outcome, Status, Variable};
use crate::state::Mode;

/// A word for each value.
pub(crate) type Words<T, const N: usize> = [(&'static str, T); N];

/// An activity's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Generic,
    Expanding,
    StayAwake,
    ManualShutdown,
    Cleanup,
}

pub(crate) const TYPES: Words<Type, 5> = [
    ("generic", Type::Generic),
    ("expanding", Type::Expanding),
    ("stay_awake", Type::StayAwake),
    ("manual_shutdown", Type::ManualShutdown),
    ("cleanup", Type::Cleanup),
];

pub(crate) const STATUSES: Words<Status, 5> = [
    ("SUCCEEDED", Status::Succeeded),
    ("FAILED", Status::Failed),
    ("ABORTED", Status::Aborted),
    ("NOT_STARTED", Status::NotStarted),
    ("COMPLETED", Status::Completed),
];

pub(crate) const OUTCOMES: Words<Outcome, 4> = [
    ("SUCCEEDED", Outcome::Succeeded),
    ("FAILED", Outcome::Failed),
    ("ABORTED", Outcome::Aborted),
    ("NOT_STARTED", Outcome::NotStarted),
];

pub(crate) const VARIABLES: Words<Variable, 2> = [("ACM", Variable::Acm), ("DDI", Variable::Ddi)];

pub(crate) const TIMELINES: Words<TimelineKind, 4> = [
    ("state", TimelineKind::State),
    ("unit", TimelineKind::Unit),
    ("renewable", TimelineKind::Renewable),
    ("consumable", TimelineKind::Consumable),
];

pub(crate) const MODES: Words<Mode, 4> = [
    ("asleep", Mode::Asleep),
    ("waking_up", Mode::WakingUp),
    ("awake", Mode::Awake),
    ("shutting_down", Mode::ShuttingDown),
];

/// What this word stands for.
pub(crate) fn read<T: Copy, const N: usize>(text: &str, words: &Words<T, N>) -> Result<T, Wrong> {
    let found = words.iter().find(|(word, _)| *word == text);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let known = words.map(|(word, _)| word);
        let wrong = Wrong::new(Rule::Unknown, format!("{} is none of these", shown(text)))
            .expected(known.join(", "));
        match nearest(&text.to_lowercase(), known.map(str::to_lowercase).iter().map(|one| &**one)) {
            Some(near) => {
                let meant = known.iter().find(|known| known.to_lowercase() == near);
                wrong.help(format!("did you mean {}?", meant.unwrap_or(&near)))
            }
            None => wrong,
        }
    })
}

/// The word for this.
pub(crate) fn word<T: Copy + PartialEq, const N: usize>(
    value: T,
    words: &Words<T, N>,
) -> &'static str {
    words.iter().find(|(_, one)| *one == value).map_or("", |(word, _)| word)
}

/// Several words, each once.
pub(crate) fn statuses(text: &str) -> Result<Vec<Status>, Wrong> {
    let mut statuses = Vec::new();
    for word in text.split_whitespace() {
        let status = read(word, &STATUSES)?;
        if statuses.contains(&status) {
            let wrong = Wrong::new(Rule::Duplicate, format!("{word} is there twice"));
            return Err(wrong.expected("each status once"));
        }
        statuses.push(status);
    }
    if statuses.is_empty() {
        let expected = STATUSES.map(|(word, _)| word).join(", ");
        return Err(Wrong::new(Rule::Missing, "there is no status").expected(expected));
    }
    Ok(statuses)
}
