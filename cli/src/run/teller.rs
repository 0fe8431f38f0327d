//! Who tells of a run: lines or documents on standard output, and the numbers
//! at its end.

use std::io;

use faregate_scheduler::manager::Note;
use faregate_scheduler::task::Task;
use faregate_scheduler::time::{Instant, Now};
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
        Self { format, changes, tally, deaf: false }
    }

    /// Tells the change.
    pub(crate) fn tell(&mut self, now: Now, note: &Note) {
        self.tally.count(note);
        if !self.deaf {
            self.deaf = self.print(now, note).is_err();
        }
    }

    fn print(&mut self, now: Now, note: &Note) -> io::Result<()> {
        let at_us = now.elapsed.as_micros();
        match self.format {
            Format::Json => out::json_line(&Change { at_us, unix_us: now.wall.as_micros(), note }),
            // That everything in the file was accepted is said by its start.
            Format::Text if matches!(note, Note::Accepted(_)) && now.elapsed == Instant::START => {
                Ok(())
            }
            Format::Text => self.changes.tell(at_us, note),
        }
    }

    /// Says something for people.
    pub(crate) fn say(&mut self, text: &str) {
        if !self.deaf && self.format == Format::Text {
            self.deaf = out::line(text).is_err();
        }
    }

    pub(crate) fn tally(&self) -> &Tally {
        &self.tally
    }
}
