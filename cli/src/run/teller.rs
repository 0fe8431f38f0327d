//! Who tells of a run: lines or documents on standard output, and the numbers
//! at its end.

use std::io;

use faregate_scheduler::manager::Note;
use faregate_scheduler::task::Task;
use faregate_scheduler::time::Now;
use serde::Serialize;

use super::tally::Tally;
use crate::args::Format;
use crate::changes::Changes;
use crate::out;

/// Tells changes. Nobody may be listening: a run goes on without its display.
#[derive(Debug)]
pub(crate) struct Teller {
    format: Format,
    changes: Changes,
    tally: Tally,
    deaf: bool,
    loading: bool,
}

/// A change, for programs.
#[derive(Serialize)]
struct Change<'a> {
    at_us: u64,
    unix_us: i64,
    note: &'a Note,
}

impl Teller {
    pub(crate) fn new(format: Format, tasks: &[Task]) -> Self {
        let (changes, tally) = (Changes::default(), Tally::of(tasks));
        Self { format, changes, tally, deaf: false, loading: true }
    }

    /// Tells the change.
    pub(crate) fn tell(&mut self, now: Now, note: &Note) {
        self.tally.count(note);
        // That the files' own tasks were accepted is said by that they run.
        self.loading &= matches!(note, Note::Accepted(_));
        if !self.deaf {
            self.deaf = self.print(now, note).is_err();
        }
    }

    fn print(&mut self, now: Now, note: &Note) -> io::Result<()> {
        let at_us = now.elapsed.as_micros();
        match self.format {
            Format::Json => out::json_line(&Change { at_us, unix_us: now.wall.as_micros(), note }),
            Format::Text if self.loading => Ok(()),
            Format::Text => self.changes.tell(at_us, note),
        }
    }

    /// Says something for people.
    pub(crate) fn say(&mut self, text: &str) {
        if !self.deaf && self.format == Format::Text {
            self.deaf = out::line(text).is_err();
        }
    }

    /// Shows a line that a task has printed.
    pub(crate) fn quote(&mut self, line: &str) {
        // What a terminal would obey is a task's own text, and not ours.
        let line: String = line.chars().filter(|letter| !letter.is_control()).collect();
        self.say(&out::styled(out::FAINT, format_args!("{:14}| {line}", "")));
    }

    pub(crate) fn tally(&self) -> &Tally {
        &self.tally
    }
}
