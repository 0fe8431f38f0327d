//! What is wrong with one value, before anybody knows where it stands.

use core::ops::Range;

use crate::format::diagnostic::{Also, Diagnostic, Rule, Severity};
use crate::format::source::Source;

/// What is wrong with one value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Wrong {
    pub(crate) rule: Rule,
    pub(crate) message: String,
    pub(crate) expected: Option<String>,
    pub(crate) help: Option<String>,
}

impl Wrong {
    pub(crate) fn new(rule: Rule, message: impl Into<String>) -> Self {
        Self { rule, message: message.into(), expected: None, help: None }
    }

    #[must_use]
    pub(crate) fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    #[must_use]
    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// Everything that is wrong with a file, gathered while it is read.
#[derive(Debug)]
pub(crate) struct Report<'a> {
    pub(crate) source: &'a Source<'a>,
    pub(crate) found: Vec<Diagnostic>,
}

impl<'a> Report<'a> {
    pub(crate) const fn new(source: &'a Source<'a>) -> Self {
        Self { source, found: Vec::new() }
    }

    /// Something because of which nothing is loaded.
    pub(crate) fn error(&mut self, span: Range<usize>, field: &str, wrong: Wrong) {
        self.add(Severity::Error, span, field, wrong);
    }

    /// Something that somebody should look at.
    pub(crate) fn warn(&mut self, span: Range<usize>, field: &str, wrong: Wrong) {
        self.add(Severity::Warning, span, field, wrong);
    }

    /// An error that has to do with another place, too.
    pub(crate) fn error_with(
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
    pub(crate) fn take<T>(
        &mut self,
        span: Range<usize>,
        field: &str,
        value: Result<T, Wrong>,
    ) -> Option<T> {
        value.map_err(|wrong| self.error(span, field, wrong)).ok()
    }

    fn add(&mut self, severity: Severity, span: Range<usize>, field: &str, wrong: Wrong) {
        self.found.push(Diagnostic {
            severity,
            rule: wrong.rule,
            file: harmless(self.source.name().to_owned()),
            place: self.source.place(span),
            field: Some(harmless(field.to_owned())).filter(|field| !field.is_empty()),
            message: harmless(wrong.message),
            expected: wrong.expected.map(harmless),
            help: wrong.help.map(harmless),
            also: None,
        });
    }
}

/// The same without control characters, which a terminal would obey: names of
/// columns, gates and files are what somebody else wrote.
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
pub(crate) fn shown(text: &str) -> String {
    let mut short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        short.push('…');
    }
    format!("`{short}`")
}
