//! The text of a file, and where in it a byte is.

use core::ops::Range;

use crate::format::diagnostic::{Diagnostic, Place, Rule, Severity};
use crate::format::wrong::Wrong;

/// A file that is being read.
#[derive(Debug)]
pub struct Source<'a> {
    name: &'a str,
    text: &'a str,
    /// Where each line begins.
    lines: Vec<usize>,
}

impl<'a> Source<'a> {
    /// The text of these bytes, without a byte order mark.
    ///
    /// # Errors
    ///
    /// The bytes are no UTF-8: the first place where they are not.
    pub fn new(name: &'a str, bytes: &'a [u8]) -> Result<Self, Vec<Diagnostic>> {
        if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
            return Err(not_utf8(Self::of(name, ""), "the file is in UTF-16"));
        }
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        match core::str::from_utf8(bytes) {
            Ok(text) => Ok(Self::of(name, text)),
            Err(wrong) => {
                let good = bytes.get(..wrong.valid_up_to()).unwrap_or_default();
                let text = core::str::from_utf8(good).unwrap_or_default();
                Err(not_utf8(Self::of(name, text), "a byte here is not UTF-8"))
            }
        }
    }

    fn of(name: &'a str, text: &'a str) -> Self {
        Self { name, text, lines: line_starts(text) }
    }

    /// The text.
    #[must_use]
    pub const fn text(&self) -> &'a str {
        self.text
    }

    /// The file's name.
    pub(crate) const fn name(&self) -> &'a str {
        self.name
    }

    /// What stands there.
    pub(crate) fn slice(&self, span: Range<usize>) -> &'a str {
        self.text.get(span.start..span.end.min(self.text.len())).unwrap_or_default()
    }

    /// Line and column of a span.
    #[must_use]
    pub fn place(&self, span: Range<usize>) -> Place {
        let start = self.boundary(span.start);
        let end = self.boundary(span.end.max(start));
        let line = self.line_of(start);
        let before = self.slice(self.line_start(line)..start);
        Place { line, column: before.chars().count() + 1, span: start..end }
    }

    /// The number of the line, from 1, in which a byte stands.
    pub(crate) fn line_of(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at)
    }

    /// Where each line begins.
    pub(crate) fn line_starts(&self) -> &[usize] {
        &self.lines
    }

    /// Where the line of this number begins.
    fn line_start(&self, line: usize) -> usize {
        self.lines.get(line.saturating_sub(1)).copied().unwrap_or(self.text.len())
    }

    /// The line in which a byte stands, its end included, and the end of the
    /// file as one more byte.
    pub(crate) fn line(&self, at: usize) -> Range<usize> {
        let line = self.line_of(at);
        self.line_start(line)..self.lines.get(line).copied().unwrap_or(self.text.len() + 1)
    }

    /// Where the line after the one of this byte begins.
    pub(crate) fn next_line(&self, at: usize) -> usize {
        self.line_start(self.line_of(at) + 1)
    }

    /// The nearest start of a character, not after this byte.
    fn boundary(&self, at: usize) -> usize {
        (0..=at.min(self.text.len())).rev().find(|at| self.text.is_char_boundary(*at)).unwrap_or(0)
    }
}

/// Spreadsheets end lines with a line feed, a carriage return, or both.
fn line_starts(text: &str) -> Vec<usize> {
    let bytes = text.as_bytes();
    let ends = bytes.iter().enumerate().filter(|(at, byte)| match byte {
        b'\n' => true,
        b'\r' => bytes.get(at + 1) != Some(&b'\n'),
        _ => false,
    });
    core::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect()
}

#[expect(clippy::needless_pass_by_value, reason = "made for this error alone")]
fn not_utf8(source: Source<'_>, message: &str) -> Vec<Diagnostic> {
    let end = source.text.len();
    let wrong = Wrong::new(Rule::Encoding, message)
        .expected("text in UTF-8")
        .help("save the file as UTF-8: spreadsheets call it \"CSV UTF-8\"");
    vec![Diagnostic::of(Severity::Error, source.name, source.place(end..end), wrong)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_and_lines_end_as_spreadsheets_end_them() {
        let text = "é1\r\nab\rc\n";
        let source = Source::new("x", text.as_bytes()).unwrap();
        let at = |what: &str| {
            let start = text.find(what).unwrap();
            let place = source.place(start..start + what.len());
            (place.line, place.column)
        };
        assert_eq!(at("1"), (1, 2));
        assert_eq!(at("b"), (2, 2));
        assert_eq!(at("c"), (3, 1));
        assert_eq!(source.place(99..99).line, 4);
    }

    #[test]
    fn what_is_not_utf8_is_told_with_its_place() {
        let latin1 = Source::new("x", b"\xEF\xBB\xBFid\n1,caf\xE9").unwrap_err();
        let latin1 = &latin1[0];
        assert_eq!((latin1.place.line, latin1.place.column), (2, 6));
        assert!(Source::new("x", b"\xFF\xFEi\0").unwrap_err()[0].message.contains("UTF-16"));
    }
}
