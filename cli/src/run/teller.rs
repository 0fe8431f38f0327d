//! Who tells of a run: lines or documents on standard output, and the numbers
//! at its end.

use faregate_scheduler::manager::Note;
use faregate_scheduler::task::Task;
use faregate_scheduler::time::Now;
use serde::Serialize;
use serde_json::json;

use super::display::Display;
use super::tally::Tally;
use crate::args::Format;
use crate::changes::{self, Changes};
use crate::exit::Failure;
use crate::out;

/// Tells changes. Nobody may be listening: a run goes on without its display.
#[derive(Debug)]
pub(crate) struct Teller {
    format: Format,
    changes: Changes,
    /// What has become of the tasks: for whoever tells changes to count them.
    pub(crate) tally: Tally,
    /// What came of a plan, and what is wanting: a plan's tasks are not what is
    /// counted then.
    plan: Option<(String, Option<String>)>,
    loading: bool,
    /// Writes the lines; none: they are written at once.
    display: Option<Display>,
}

/// A change, for programs.
#[derive(Serialize)]
struct Change<'a> {
    at_us: u64,
    unix_us: i64,
    note: &'a Note,
}

impl Teller {
    pub(crate) fn new(format: Format) -> Self {
        let (changes, tally) = (Changes::default(), Tally::default());
        Self { format, changes, tally, plan: None, loading: true, display: None }
    }

    /// From now on nobody who tells something waits for a reader.
    ///
    /// # Errors
    /// When the host has no thread left.
    pub(crate) fn for_real_time(self) -> Result<Self, Failure> {
        let tells_lost = match self.format {
            Format::Json => |count| json!({ "lost": count }).to_string(),
            Format::Text => changes::lost,
        };
        let display = Display::new(tells_lost).map_err(|error| {
            Failure::failed(format!("the host has no thread for the display: {error}"))
        })?;
        Ok(Self { display: Some(display), ..self })
    }

    /// The run is over: what is still to be told waits for whoever reads it.
    pub(crate) fn wait_again(&mut self) {
        self.display = None;
    }

    /// Tells the change.
    pub(crate) fn tell(&mut self, now: Now, note: &Note) {
        // That the files' own tasks were accepted is said by that they run.
        self.loading &= matches!(note, Note::Accepted(_));
        let at_us = now.elapsed.as_micros();
        let line = match self.format {
            Format::Json => {
                let change = Change { at_us, unix_us: now.wall.as_micros(), note };
                serde_json::to_string(&change).ok()
            }
            Format::Text if self.loading => None,
            Format::Text => self.changes.told(at_us, note),
        };
        line.into_iter().for_each(|line| self.put(line));
    }

    /// A plan was executed, and this came of it; and what the mission needed and
    /// did not get.
    pub(crate) fn executed(&mut self, result: String, wanting: Option<String>) {
        self.plan = Some((result, wanting));
    }

    /// What came of the run.
    pub(crate) fn result(&self) -> String {
        match &self.plan {
            Some((result, _)) => result.clone(),
            None => self.tally.to_string(),
        }
    }

    /// What went wrong of what the mission needs.
    pub(crate) fn wanting(&self) -> Option<String> {
        match &self.plan {
            Some((_, wanting)) => wanting.clone(),
            None => self.tally.wanting(),
        }
    }

    /// Tells that the planner has planned, or cannot.
    pub(crate) fn planner(&mut self, now: Now, what: &str) {
        let at_us = now.elapsed.as_micros();
        self.put(match self.format {
            Format::Json => json!({ "at_us": at_us, "planned": what }).to_string(),
            Format::Text => changes::said(at_us, "planned", what),
        });
    }

    /// The task's name is told with its number from now on.
    pub(crate) fn call(&mut self, task: &Task) {
        self.changes.call(task.id, task.name.as_deref());
    }

    /// Who has gone need not be told.
    fn put(&mut self, line: String) {
        match &mut self.display {
            Some(display) => display.line(line),
            None => drop(out::line(line)),
        }
    }

    /// Says something for people.
    pub(crate) fn say(&mut self, text: &str) {
        if self.format == Format::Text {
            self.put(text.to_owned());
        }
    }

    /// Shows a line that a task has printed.
    pub(crate) fn quote(&mut self, line: &str) {
        self.say(&out::styled(out::FAINT, format_args!("{:14}| {}", "", harmless(line))));
    }
}

/// The line without what a terminal would obey: that is a task's own text, and
/// not ours.
pub(super) fn harmless(line: &str) -> String {
    line.chars().filter(|letter| !letter.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_obeys_nothing_that_a_task_prints() {
        assert_eq!(harmless("no\u{1b}[2J\r film\u{9b}"), "no[2J film");
    }
}
