//! One line for each change: when, what, which task, why.

use std::collections::BTreeMap;

use anstyle::Style;
use faregate_scheduler::TaskId;
use faregate_scheduler::manager::{Exit, Note, Occurrence};
use faregate_scheduler::task::Outcome;

use crate::out::{self, BAD, FAINT, GOOD, ODD, STRONG};
use crate::times::shown;

/// Turns changes into lines.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    /// The occurrence whose last attempt was just told to be over: that the
    /// occurrence is over is then no news.
    over: Option<(Occurrence, Outcome)>,
    /// What tasks of a plan are called.
    names: BTreeMap<TaskId, Option<String>>,
}

/// How it is told that so many changes were not.
pub(crate) fn lost(count: u64) -> String {
    out::styled(ODD, format_args!("{count} changes were not told"))
}

/// A change that no task is about.
pub(crate) fn said(at_us: u64, state: &str, what: &str) -> String {
    in_columns(at_us, (STRONG, state), what, "")
}

fn in_columns(at_us: u64, (style, state): (Style, &str), who: &str, why: &str) -> String {
    let state = out::styled(style, format_args!("{state:<10}"));
    let line = format!("{:>12}  {state}  {who:<24}  {why}", shown(at_us, 3));
    line.trim_end().to_owned()
}

/// A line, in its columns.
struct Line {
    style: Style,
    state: &'static str,
    who: String,
    why: String,
}

impl Changes {
    /// From now on the task's name is told with its number. That it comes into
    /// the schedule, and leaves it before it starts, is what a plan does all the
    /// time, and is not told.
    pub(crate) fn call(&mut self, task: TaskId, name: Option<&str>) {
        self.names.insert(task, name.map(str::to_owned));
    }

    /// The change in a line, if it is news.
    pub(crate) fn told(&mut self, at_us: u64, note: &Note) -> Option<String> {
        self.line(note).map(|line| line.shown(at_us))
    }

    fn line(&mut self, note: &Note) -> Option<Line> {
        let over = self.over.take();
        match note {
            Note::Over { attempt, outcome, .. } => self.over = Some((attempt.occurrence, *outcome)),
            Note::Ended { occurrence, outcome } if over == Some((*occurrence, *outcome)) => {
                return None;
            }
            _ => {}
        }
        let mut line = Line::of(note);
        let name = task_of(note).and_then(|task| self.names.get(&task));
        match (name, note) {
            (Some(_), Note::Accepted(_) | Note::Removed(_)) => return None,
            (Some(Some(name)), _) => line.who = format!("{}, {name}", line.who),
            _ => {}
        }
        Some(line)
    }
}

impl Line {
    fn of(note: &Note) -> Self {
        let new = |style, state, who: String, why: String| Self { style, state, who, why };
        let none = String::new;
        match note {
            Note::Accepted(task) => new(FAINT, "accepted", task.to_string(), none()),
            Note::Removed(task) => new(ODD, "removed", task.to_string(), none()),
            Note::Waits { occurrence, waits_for } => {
                new(FAINT, "waits", occurrence.to_string(), format!("for {waits_for}"))
            }
            Note::Started(attempt) => new(GOOD, "started", attempt.to_string(), none()),
            Note::Stopping { attempt, why } => {
                new(ODD, "stopping", attempt.to_string(), why.clone())
            }
            Note::Paused(attempt) => new(ODD, "paused", attempt.to_string(), none()),
            Note::Resumed(attempt) => new(GOOD, "resumed", attempt.to_string(), none()),
            Note::Preempted(attempt) => {
                new(ODD, "pre-empted", attempt.to_string(), "to be run again".into())
            }
            Note::Over { attempt, exit, outcome } => {
                new(style(*outcome), word(*outcome), attempt.to_string(), how(exit))
            }
            Note::Ended { occurrence, outcome } => {
                new(style(*outcome), word(*outcome), occurrence.to_string(), none())
            }
            Note::Missed { task, first, last, count, why } => {
                let which = match count {
                    1 => format!("occurrence {first}: "),
                    _ => format!("{count} occurrences, {first} to {last}: "),
                };
                new(BAD, "missed", task.to_string(), which + why)
            }
            Note::NeverRuns { task, why } => new(BAD, "never runs", task.to_string(), why.clone()),
            Note::Overran { attempt, duration } => {
                let why = format!("has run longer than its {duration}");
                new(ODD, "overran", attempt.to_string(), why)
            }
            Note::Runaway(attempt) => {
                let why = "did not return after its grace; its worker is lost";
                new(BAD, "runaway", attempt.to_string(), why.into())
            }
            Note::Mode { name, entered: true } => {
                new(STRONG, "entered", format!("mode {name}"), none())
            }
            Note::Mode { name, entered: false } => {
                new(STRONG, "left", format!("mode {name}"), none())
            }
        }
    }

    fn shown(&self, at_us: u64) -> String {
        let Self { style, state, who, why } = self;
        in_columns(at_us, (*style, state), who, why)
    }
}

/// Whom a change is about.
const fn task_of(note: &Note) -> Option<TaskId> {
    Some(match note {
        Note::Accepted(task)
        | Note::Removed(task)
        | Note::Missed { task, .. }
        | Note::NeverRuns { task, .. } => *task,
        Note::Waits { occurrence, .. } | Note::Ended { occurrence, .. } => occurrence.task,
        Note::Started(attempt)
        | Note::Paused(attempt)
        | Note::Resumed(attempt)
        | Note::Preempted(attempt)
        | Note::Runaway(attempt)
        | Note::Stopping { attempt, .. }
        | Note::Over { attempt, .. }
        | Note::Overran { attempt, .. } => attempt.occurrence.task,
        Note::Mode { .. } => return None,
    })
}

fn style(outcome: Outcome) -> Style {
    match outcome {
        Outcome::Succeeded => GOOD,
        Outcome::Failed | Outcome::Aborted | Outcome::Missed => BAD,
    }
}

fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Succeeded => "succeeded",
        Outcome::Failed => "failed",
        Outcome::Aborted => "aborted",
        Outcome::Missed => "missed",
    }
}

/// What success looks like needs no words.
fn how(exit: &Exit) -> String {
    match exit {
        Exit::Code(0) => String::new(),
        // That it failed stands in front of it.
        Exit::Failed(why) => why.clone(),
        _ => exit.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use faregate_scheduler::TaskId;
    use faregate_scheduler::manager::{Attempt, WaitsFor};

    use super::*;

    fn occurrence() -> Occurrence {
        Occurrence { task: TaskId::new(31).unwrap(), load: 0, number: 0 }
    }

    fn plain(changes: &mut Changes, note: &Note) -> Option<String> {
        let line = changes.told(5_000_001, note)?;
        Some(anstream::adapter::strip_str(&line).to_string())
    }

    #[test]
    fn a_line_says_when_what_who_and_why() {
        let waits = Note::Waits { occurrence: occurrence(), waits_for: WaitsFor::Held };
        assert_eq!(
            plain(&mut Changes::default(), &waits).unwrap(),
            "       5.000  waits       task 31                   for a telecommand: it is held"
        );
    }

    #[test]
    fn an_occurrence_whose_attempt_was_told_to_be_over_is_no_news_and_a_missed_one_is() {
        let attempt = Attempt { occurrence: occurrence(), number: 1 };
        let over = Note::Over { attempt, exit: Exit::Signal(9), outcome: Outcome::Failed };
        let ended = |outcome| Note::Ended { occurrence: occurrence(), outcome };
        let mut changes = Changes::default();
        assert!(plain(&mut changes, &over).unwrap().contains("signal 9"));
        assert_eq!(plain(&mut changes, &ended(Outcome::Failed)), None);
        assert!(plain(&mut changes, &over).is_some());
        assert!(plain(&mut changes, &ended(Outcome::Aborted)).is_some(), "it is another outcome");
        assert!(plain(&mut changes, &ended(Outcome::Failed)).is_some(), "it stands alone");
    }
}
