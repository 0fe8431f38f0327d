//! Where the tasks stand, for who asks.

use faregate_client::wire::control::{
    Answer, MAX_ROWS, State as Told, Status, StatusQuery, TaskRow,
};
use faregate_client::{RefusalKind, Refused};

use crate::manager::{Attempt, Manager, State, TaskStatus};
use crate::task::{Outcome, Task, TaskId};
use crate::time::Now;

/// What knows where the tasks stand: the manager.
pub trait StatusSource {
    /// Every task of the schedule, in its order.
    fn each(&self) -> impl Iterator<Item = TaskId>;

    /// Where the task stands, if it is in the schedule.
    fn status(&self, id: TaskId) -> Option<TaskStatus>;

    /// The task, if it is in the schedule.
    fn task(&self, id: TaskId) -> Option<&Task>;

    /// Whether the mission has a mode of this name.
    fn has_mode(&self, name: &str) -> bool;
}

impl StatusSource for Manager {
    fn each(&self) -> impl Iterator<Item = TaskId> {
        self.tasks().map(|task| task.id)
    }

    fn status(&self, id: TaskId) -> Option<TaskStatus> {
        self.status_of(id)
    }

    fn task(&self, id: TaskId) -> Option<&Task> {
        Self::task(self, id)
    }

    fn has_mode(&self, name: &str) -> bool {
        Self::has_mode(self, name)
    }
}

/// The answer to a query, at this instant.
///
/// # Timing
/// A step for each task up to the last one in the answer, which has at most
/// [`MAX_ROWS`]: long schedules are told in several answers, and asked of in
/// several questions, so that none keeps the manager for long.
pub(super) fn answer(query: StatusQuery, source: &impl StatusSource, now: Now) -> Answer {
    let asked = query.tasks.len();
    if u32::try_from(asked).is_ok_and(|asked| asked <= MAX_ROWS) {
        return Answer::Status(status(query, source, now));
    }
    let why = format!("one question is about {MAX_ROWS} tasks at the most, and this about {asked}");
    Answer::Refused(Refused::new(RefusalKind::Invalid, why))
}

fn status(mut query: StatusQuery, source: &impl StatusSource, now: Now) -> Status {
    let limit = query.limit.unwrap_or(MAX_ROWS).min(MAX_ROWS);
    query.tasks.sort_unstable();
    let tasks = query.tasks;
    let wanted = |id: TaskId| tasks.is_empty() || tasks.binary_search(&id.get()).is_ok();
    let mut rest = source
        .each()
        .filter(|id| wanted(*id))
        .skip(usize::try_from(query.skip).unwrap_or(usize::MAX));
    let shown = rest.by_ref().take(usize::try_from(limit).unwrap_or(usize::MAX));
    // What one waits for takes words: they are made for those that are told.
    let tasks = shown.filter_map(|id| Some(row(source.status(id)?, source))).collect();
    Status {
        at_us: now.elapsed.as_micros(),
        unix_us: now.wall.as_micros(),
        tasks,
        more: rest.next().is_some(),
    }
}

fn row(status: TaskStatus, source: &impl StatusSource) -> TaskRow {
    let TaskStatus { occurrence, state } = status;
    let task = source.task(occurrence.task);
    let mut row = TaskRow {
        task: occurrence.task.get(),
        name: task.and_then(|task| task.name.clone()),
        occurrence: occurrence.number,
        priority: task.map_or(0, |task| task.priority.level()),
        state: told(&state),
        attempt: attempt(&state).map(|attempt| attempt.number),
        due_us: None,
        due_unix_us: None,
        waits_for: None,
    };
    match state {
        State::Pending(due) => {
            row.due_us = due.elapsed.map(|at| at.as_micros());
            row.due_unix_us = due.wall.map(|at| at.as_micros());
        }
        State::Waiting(waits_for) | State::Paused(_, waits_for) => {
            row.waits_for = Some(waits_for.to_string());
        }
        State::Running(_) | State::Stopping(_) | State::Ended(_) => {}
    }
    row
}

const fn attempt(state: &State) -> Option<Attempt> {
    match state {
        State::Running(attempt) | State::Stopping(attempt) | State::Paused(attempt, _) => {
            Some(*attempt)
        }
        State::Pending(_) | State::Waiting(_) | State::Ended(_) => None,
    }
}

const fn told(state: &State) -> Told {
    match state {
        State::Pending(_) => Told::Pending,
        State::Waiting(_) => Told::Waiting,
        State::Running(_) => Told::Running,
        State::Stopping(_) => Told::Stopping,
        State::Paused(..) => Told::Paused,
        State::Ended(Outcome::Succeeded) => Told::Succeeded,
        State::Ended(Outcome::Failed) => Told::Failed,
        State::Ended(Outcome::Aborted) => Told::Aborted,
        State::Ended(Outcome::Missed) => Told::Missed,
    }
}
