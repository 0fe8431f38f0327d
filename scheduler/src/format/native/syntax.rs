//! Mistakes of syntax, and what follows from them alone.

use core::ops::Range;

use toml::de::Error;

use crate::format::diagnostic::{Diagnostic, Rule};
use crate::format::source::Source;
use crate::format::wrong::{Report, Wrong};

/// The mistakes of syntax of a file. The parser goes on after each, and what
/// it makes of the rest of a broken line is not what was meant.
#[derive(Debug)]
pub(crate) struct Syntax {
    wrong: Vec<(Range<usize>, Wrong)>,
    /// Where nothing else is told.
    quiet: Vec<Range<usize>>,
    /// Tables of which nothing is said to be missing.
    partial: Vec<Range<usize>>,
}

impl Syntax {
    pub(crate) fn new(errors: &[Error], report: &Report<'_>) -> Self {
        let source = report.source;
        let mut all = Self { wrong: Vec::new(), quiet: Vec::new(), partial: Vec::new() };
        let headers = Headers::new(source);
        let mut line = 0;
        for error in errors {
            let at = error.span().unwrap_or_default();
            // One mistake can be told several times in its line.
            let here = source.line_of(at.start);
            if here != core::mem::replace(&mut line, here) {
                all.partial.push(headers.table(at.start));
                all.quiet.push(headers.spoilt(at.start));
                all.wrong.push((at, told(error)));
            }
        }
        all.partial = merged(all.partial);
        all.quiet = merged(all.quiet);
        all
    }

    /// Tells of them, and takes back what only follows from them.
    pub(crate) fn tell(self, report: &mut Report<'_>) {
        let within = |ranges: &[Range<usize>], found: &Diagnostic| {
            let at = found.place.span.start;
            let before = ranges.partition_point(|range| range.start <= at).checked_sub(1);
            before.and_then(|index| ranges.get(index)).is_some_and(|range| range.contains(&at))
        };
        report.found.retain(|found| {
            let missed = found.rule == Rule::Missing && within(&self.partial, found);
            !missed && !within(&self.quiet, found)
        });
        for (at, wrong) in self.wrong {
            report.error(at, "", wrong);
        }
    }
}

/// The same places as ranges that do not overlap, in order: they are searched
/// for each message, and a broken file can have many of both.
fn merged(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    ranges.sort_by_key(|range| range.start);
    ranges.dedup_by(|next, before| {
        let touch = next.start <= before.end;
        before.end = if touch { before.end.max(next.end) } else { before.end };
        touch
    });
    ranges
}

fn told(error: &Error) -> Wrong {
    let message = error.message().lines().next().unwrap_or("this is not TOML");
    let (what, expected) = message.split_once(", expected ").unwrap_or((message, "TOML"));
    Wrong::new(Rule::Syntax, what).expected(expected)
}

/// Where the headers of tables stand.
struct Headers<'a> {
    source: &'a Source<'a>,
    starts: Vec<usize>,
}

impl<'a> Headers<'a> {
    fn new(source: &'a Source<'a>) -> Self {
        let is_header =
            |start: &usize| source.slice(source.line(*start)).trim_ascii_start().starts_with('[');
        Self { source, starts: source.line_starts().iter().copied().filter(is_header).collect() }
    }

    /// The table in which this stands.
    fn table(&self, at: usize) -> Range<usize> {
        let next = self.starts.partition_point(|start| *start <= at);
        let start = next.checked_sub(1).and_then(|before| self.starts.get(before));
        let end = self.starts.get(next).copied().unwrap_or(self.source.text().len() + 1);
        start.copied().unwrap_or(0)..end
    }

    /// The line, or all that stands under a broken header.
    fn spoilt(&self, at: usize) -> Range<usize> {
        let line = self.source.line(at);
        if self.starts.binary_search(&line.start).is_ok() { self.table(at) } else { line }
    }
}
