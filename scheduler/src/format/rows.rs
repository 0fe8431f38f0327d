//! Rows of fields, from text with commas or with spaces.

use core::ops::Range;

use csv_core::{ReadFieldResult, Reader};

use crate::format::diagnostic::Rule;
use crate::format::source::Source;
use crate::format::wrong::{Report, Wrong};

/// A field of a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Cell {
    pub(crate) text: String,
    pub(crate) at: Range<usize>,
    /// Whether it could be read. It was told of if not.
    pub(crate) good: bool,
}

/// A row that is not blank.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Row {
    pub(crate) cells: Vec<Cell>,
}

impl Row {
    pub(crate) fn at(&self) -> Range<usize> {
        let start = self.cells.first().map_or(0, |cell| cell.at.start);
        start..self.cells.last().map_or(start, |cell| cell.at.end)
    }

    /// Spreadsheets save empty rows as commas.
    fn is_blank(&self) -> bool {
        self.cells.iter().all(|cell| cell.good && cell.text.is_empty())
    }
}

/// The rows of a file with commas.
pub(crate) fn of_csv(report: &mut Report<'_>) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut from = 0;
    // Long enough for any field.
    let mut buffer = vec![0; report.source.text().len() + 1];
    while let Some(to) = section(report, from, &mut buffer, &mut rows) {
        from = to;
    }
    rows.retain(|row| !row.is_blank());
    rows
}

/// Reads until the end, or until a quote that is not closed in its line nor
/// rightly in another: it would hide what follows, so reading goes on in the
/// next line.
fn section(
    report: &mut Report<'_>,
    from: usize,
    buffer: &mut [u8],
    rows: &mut Vec<Row>,
) -> Option<usize> {
    let mut reader = Fields::new(report.source, from, buffer);
    let mut row = Row::default();
    while let Some(field) = reader.next_field() {
        let (cell, wrong) = judge(report.source, field.text, field.at);
        let unclosed = wrong.as_ref().is_some_and(|(_, unclosed)| *unclosed);
        if let Some((wrong, _)) = wrong {
            report.error(cell.at.clone(), "", wrong);
        }
        let next = unclosed.then(|| report.source.next_line(cell.at.start));
        row.cells.push(cell);
        if field.ends_row || next.is_some() {
            rows.push(core::mem::take(&mut row));
        }
        if next.is_some() {
            return next;
        }
    }
    None
}

/// A field as the reader found it.
struct Field {
    text: String,
    at: Range<usize>,
    ends_row: bool,
}

/// The fields of a text, with where they stand.
struct Fields<'a, 'b> {
    reader: Reader,
    source: &'a Source<'a>,
    at: usize,
    buffer: &'b mut [u8],
    starts_row: bool,
}

impl<'a, 'b> Fields<'a, 'b> {
    fn new(source: &'a Source<'a>, from: usize, buffer: &'b mut [u8]) -> Self {
        Self { reader: Reader::new(), source, at: from, buffer, starts_row: true }
    }

    fn next_field(&mut self) -> Option<Field> {
        let (start, mut length) = (self.at, 0);
        loop {
            let rest = self.source.text().as_bytes().get(self.at..).unwrap_or_default();
            let buffer = self.buffer.get_mut(length..)?;
            let (result, read, written) = self.reader.read_field(rest, buffer);
            self.at += read;
            length += written;
            match result {
                // The next call has no input, which is how the reader is told
                // of the end.
                ReadFieldResult::InputEmpty => {}
                ReadFieldResult::OutputFull | ReadFieldResult::End => return None,
                ReadFieldResult::Field { record_end } => {
                    return self.field(start, length, record_end);
                }
            }
        }
    }

    fn field(&mut self, start: usize, length: usize, ends_row: bool) -> Option<Field> {
        let raw = self.source.slice(start..self.at);
        let trimmed = if self.starts_row { raw.trim_start_matches(['\r', '\n']) } else { raw };
        let start = start + (raw.len() - trimmed.len());
        let end = if ends_row {
            trimmed.trim_end_matches(['\r', '\n'])
        } else {
            trimmed.strip_suffix(',').unwrap_or(trimmed)
        };
        self.starts_row = ends_row;
        let text = core::str::from_utf8(self.buffer.get(..length)?).ok()?.to_owned();
        Some(Field { text, at: start..start + end.len(), ends_row })
    }
}

/// The cell of a field, and what is wrong with its quotes: `true` where they
/// are not closed.
fn judge(source: &Source<'_>, text: String, at: Range<usize>) -> (Cell, Option<(Wrong, bool)>) {
    let raw = source.slice(at.clone());
    let bare = raw.trim_ascii_start();
    let wrong = match bare.strip_prefix('"') {
        None => None,
        Some(_) if bare.len() < raw.len() => Some((spaced(), false)),
        Some(inside) => match closing(inside) {
            None => Some((unclosed(), true)),
            Some(rest) if rest.trim_ascii().is_empty() => None,
            Some(_) if raw.contains(['\r', '\n']) => Some((unclosed(), true)),
            Some(_) => Some((trailing(), false)),
        },
    };
    let start = if bare.is_empty() { at.start } else { at.end - bare.len() };
    let shown = bare.split(['\r', '\n']).next().unwrap_or_default().trim_ascii_end();
    let end =
        if wrong.is_some() { start + shown.len() } else { start + bare.trim_ascii_end().len() };
    (Cell { text: text.trim_ascii().to_owned(), at: start..end, good: wrong.is_none() }, wrong)
}

/// What follows the closing quote; `None` where there is none.
fn closing(inside: &str) -> Option<&str> {
    let mut rest = inside;
    loop {
        rest = rest.split_once('"')?.1;
        match rest.strip_prefix('"') {
            Some(escaped) => rest = escaped,
            None => return Some(rest),
        }
    }
}

fn unclosed() -> Wrong {
    Wrong::new(Rule::Quote, "this quote is not closed").expected("a closing quote")
}

fn trailing() -> Wrong {
    Wrong::new(Rule::Quote, "something follows the closing quote")
        .expected("a comma or the end of the line")
        .help("write a quote inside a quoted field twice")
}

fn spaced() -> Wrong {
    Wrong::new(Rule::Quote, "a quoted field begins with a space")
        .expected("the quote right after the comma")
}

/// The rows of a file with spaces: so many fields, and the rest of the line.
pub(crate) fn of_txt(source: &Source<'_>, fields: usize) -> Vec<Row> {
    let text = source.text();
    let mut rows = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive(['\n', '\r']) {
        rows.push(words(line, start, fields));
        start += line.len();
    }
    rows.retain(|row| !row.is_blank());
    rows
}

fn words(line: &str, start: usize, fields: usize) -> Row {
    let mut row = Row::default();
    let mut rest = line;
    while !rest.trim_ascii_start().is_empty() {
        rest = rest.trim_ascii_start();
        let last = row.cells.len() == fields;
        let length = if last { None } else { rest.find(|one: char| one.is_ascii_whitespace()) };
        let word = rest.get(..length.unwrap_or(rest.len())).unwrap_or_default();
        let from = start + line.len() - rest.len();
        let text = word.trim_ascii_end().to_owned();
        let at = from..from + text.len();
        row.cells.push(Cell { text, at, good: true });
        rest = rest.get(word.len()..).unwrap_or_default();
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn csv(text: &str) -> (Vec<Vec<String>>, Vec<(usize, usize)>) {
        let source = Source::new("x", text.as_bytes()).unwrap();
        let mut report = Report::new(&source);
        let rows = of_csv(&mut report);
        let told = report.found.iter().map(|wrong| (wrong.place.line, wrong.place.column));
        let texts = |row: Row| row.cells.into_iter().map(|cell| cell.text).collect();
        (rows.into_iter().map(texts).collect(), told.collect())
    }

    #[test]
    fn fields_are_where_they_stand_in_the_file() {
        let text = "a,bc\r\n\r\n,,\r\n  d ,\"e\"\n\"f\"\"g\",\"h,\ni\"";
        let source = Source::new("x", text.as_bytes()).unwrap();
        let rows = of_csv(&mut Report::new(&source));
        let raw: Vec<_> = rows
            .iter()
            .flat_map(|row| &row.cells)
            .map(|cell| source.slice(cell.at.clone()))
            .collect();
        assert_eq!(raw, ["a", "bc", "d", "\"e\"", "\"f\"\"g\"", "\"h,\ni\""]);
        assert_eq!(rows[2].cells[0].text, "f\"g");
        assert_eq!(rows[2].cells[1].text, "h,\ni");
    }

    #[test]
    fn a_quote_that_is_never_closed_hides_only_its_own_line() {
        let (rows, told) = csv("a,\"b\nc,d\n\"e\"x,f\ng,h\n");
        assert_eq!(told, [(1, 3), (3, 1)]);
        assert_eq!(rows.last().unwrap(), &["g", "h"]);
    }

    #[test]
    fn a_row_ends_with_its_line_in_a_file_with_spaces() {
        let source = Source::new("x", b"1\t 2  sleep  3 \r\n \n4 5\r6").unwrap();
        let rows = of_txt(&source, 2);
        let texts: Vec<Vec<_>> = rows
            .iter()
            .map(|row| row.cells.iter().map(|cell| cell.text.as_str()).collect())
            .collect();
        assert_eq!(texts, [vec!["1", "2", "sleep  3"], vec!["4", "5"], vec!["6"]]);
        assert_eq!(source.slice(rows[0].cells[2].at.clone()), "sleep  3");
    }
}
