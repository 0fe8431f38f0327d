//! What is wrong with one value, before anybody knows where it stands.

use core::ops::Range;

use crate::format::diagnostic::{Also, Diagnostic, Rule, Severity};
use crate::format::source::Source;

/// What is wrong with one value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// Which rule was broken.
    pub rule: Rule,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub expected: Option<String>,
    /// What to do.
    pub help: Option<String>,
}

impl Wrong {
    /// This is wrong, by this rule.
    pub fn new(rule: Rule, message: impl Into<String>) -> Self {
        Self { rule, message: message.into(), expected: None, help: None }
    }

    /// Says what would be right.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    /// Says what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// Everything that is wrong with a file, gathered while it is read.
#[derive(Debug)]
pub struct Report<'a> {
    /// The file.
    pub source: &'a Source<'a>,
    /// What was found so far.
    pub found: Vec<Diagnostic>,
    /// How many errors there were, those that were taken back among them.
    errors: usize,
}

/// How many errors a file may have before it is read no further: what is no
/// schedule at all has one in each line.
const HOPELESS: usize = 10_000;

/// How many tasks a file may have. They come into the schedule at one instant,
/// and into the journal in one piece.
pub(crate) const MOST_TASKS: usize = 250_000;

impl<'a> Report<'a> {
    /// Of a file in which nothing was found yet.
    #[must_use]
    pub const fn new(source: &'a Source<'a>) -> Self {
        Self { source, found: Vec::new(), errors: 0 }
    }

    /// Whether so much is wrong that nothing more need be read.
    #[must_use]
    pub const fn is_hopeless(&self) -> bool {
        self.errors >= HOPELESS
    }

    /// Whether another task after so many is not to be read: there are too many
    /// of them, which is told, or it is hopeless.
    pub(crate) fn is_enough(&mut self, tasks: usize, next: Range<usize>) -> bool {
        if tasks == MOST_TASKS {
            let message = format!("here begin more than {MOST_TASKS} tasks");
            let wrong = Wrong::new(Rule::Range, message).help("load them in several files");
            self.error(next, "", wrong);
            self.errors += HOPELESS;
        }
        self.is_hopeless()
    }

    /// Something because of which nothing is loaded.
    pub fn error(&mut self, span: Range<usize>, field: &str, wrong: Wrong) {
        self.add(Severity::Error, span, field, wrong);
    }

    /// Something that somebody should look at.
    pub fn warn(&mut self, span: Range<usize>, field: &str, wrong: Wrong) {
        self.add(Severity::Warning, span, field, wrong);
    }

    /// An error that has to do with another place, too.
    pub fn error_with(
        &mut self,
        span: Range<usize>,
        field: &str,
        wrong: Wrong,
        also: (Range<usize>, String),
    ) {
        self.add(Severity::Error, span, field, wrong);
        let place = self.source.place(also.0);
        if let Some(last) = self.found.last_mut() {
            last.also = Some(Also { place, message: also.1 });
        }
    }

    /// The value, or nothing and an error at its place.
    pub fn take<T>(
        &mut self,
        span: Range<usize>,
        field: &str,
        value: Result<T, Wrong>,
    ) -> Option<T> {
        value.map_err(|wrong| self.error(span, field, wrong)).ok()
    }

    fn add(&mut self, severity: Severity, span: Range<usize>, field: &str, wrong: Wrong) {
        self.errors += usize::from(severity == Severity::Error);
        let place = self.source.place(span);
        let field = Some(harmless(field.to_owned())).filter(|field| !field.is_empty());
        let found = Diagnostic::of(severity, self.source.name(), place, wrong);
        self.found.push(Diagnostic { field, ..found });
    }
}

/// The same, with escapes in the place of control characters.
pub(crate) fn harmless(text: String) -> String {
    if !text.contains(char::is_control) {
        return text;
    }
    let escape =
        |one: char| if one.is_control() { one.escape_debug().to_string() } else { one.into() };
    text.chars().map(escape).collect()
}

/// A piece of a file as a message shows it: short, and without control
/// characters that a terminal would obey.
#[must_use]
pub fn shown(text: &str) -> String {
    let mut short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        short.push('…');
    }
    format!("`{short}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_tasks_than_one_file_may_have_are_one_mistake_and_not_read() {
        let source = Source::new("a.csv", b"1\n2\n").unwrap();
        let mut report = Report::new(&source);
        assert!(!report.is_enough(0, 0..1) && !report.is_enough(MOST_TASKS - 1, 0..1));
        assert_eq!(report.found, []);
        assert!(report.is_enough(MOST_TASKS, 2..3) && report.is_hopeless());
        let [told] = &*report.found else { panic!("{:?}", report.found) };
        assert_eq!((told.place.line, told.rule), (2, Rule::Range));
    }
}
