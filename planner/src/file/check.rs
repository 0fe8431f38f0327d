//! What is right or wrong about whole plans, parameters and states: each value
//! could be read, and the question is whether they can be meant together.

mod activity;
mod dependencies;
mod overflow;
mod parameters;
mod plan;
mod state;
mod together;

pub(super) use parameters::parameters;
pub(super) use plan::plan;
pub(super) use state::state;
pub(super) use together::together;

use faregate_scheduler::format::reading::{Report, Wrong};
use faregate_scheduler::format::{Diagnostic, Rule};
use faregate_tickets::amount::Milliwatts;

use crate::file::show;
use crate::file::xml::Element;

/// Whether no error was told since so many things were found.
fn clean(report: &Report<'_>, before: usize) -> bool {
    !report.found.iter().skip(before).any(Diagnostic::is_error)
}

/// That more is drawn on average than at most.
const PEAK_BELOW: &str = "its peak is below its average power: the limit of peaks does not see it";

fn raise(marginal: Milliwatts) -> String {
    format!("give it a peak of {} or more", show::power(marginal))
}

/// What is told about one element.
struct About<'e, 'r, 's> {
    element: &'e Element<'e>,
    /// Put in front of each message: compact files have no lines.
    who: String,
    report: &'r mut Report<'s>,
}

impl<'e, 'r, 's> About<'e, 'r, 's> {
    const fn new(element: &'e Element<'e>, who: String, report: &'r mut Report<'s>) -> Self {
        Self { element, who, report }
    }

    fn error(&mut self, name: &str, rule: Rule, message: &str, expected: impl Into<String>) {
        self.error_at(self.element, name, rule, message, expected);
    }

    /// The same at an element within.
    fn error_at(
        &mut self,
        element: &Element<'_>,
        name: &str,
        rule: Rule,
        message: &str,
        expected: impl Into<String>,
    ) {
        let wrong = self.wrong(rule, message).expected(expected);
        self.report.error(element.span(name), &field(element, name), wrong);
    }

    fn warn(&mut self, name: &str, rule: Rule, message: &str, help: Option<String>) {
        self.warn_at(self.element, name, rule, message, help);
    }

    fn warn_at(
        &mut self,
        element: &Element<'_>,
        name: &str,
        rule: Rule,
        message: &str,
        help: Option<String>,
    ) {
        let wrong = Wrong { help, ..self.wrong(rule, message) };
        self.report.warn(element.span(name), &field(element, name), wrong);
    }

    fn wrong(&self, rule: Rule, message: &str) -> Wrong {
        Wrong::new(rule, format!("{}: {message}", self.who))
    }
}

fn field(element: &Element<'_>, name: &str) -> String {
    match name {
        "" => element.name.to_string(),
        _ => format!("{}.{name}", element.name),
    }
}
