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
        Self { format, changes, tally, loading: true }
    }

    /// Tells the change.
    pub(crate) fn tell(&mut self, now: Now, note: &Note) {
        self.tally.count(note);
        // That the files' own tasks were accepted is said by that they run.
        self.loading &= matches!(note, Note::Accepted(_));
        // Who has gone need not be told.
        let _ = self.print(now, note);
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
    pub(crate) fn say(&self, text: &str) {
        if self.format == Format::Text {
            let _ = out::line(text);
        }
    }

    /// Shows a line that a task has printed.
    pub(crate) fn quote(&self, line: &str) {
        self.say(&out::styled(out::FAINT, format_args!("{:14}| {}", "", harmless(line))));
    }

    pub(crate) fn tally(&self) -> &Tally {
        &self.tally
    }
}

/// The line without what a terminal would obey: that is a task's own text, and
/// not ours.
fn harmless(line: &str) -> String {
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
