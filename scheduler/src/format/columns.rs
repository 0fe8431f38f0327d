//! The columns of SMAARTE's files, and ours.

use core::ops::Range;

use crate::format::diagnostic::Rule;
use crate::format::suggest;
use crate::format::wrong::{Report, Wrong, shown};

/// A column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Column {
    Id,
    Start,
    End,
    Duration,
    Conflict,
    Priority,
    Type,
    Interval,
    Memory,
    Storage,
    Power,
    Draw,
    Gap,
    Cutoff,
    Preempt,
    Gates,
    Args,
}

impl Column {
    /// All of them, in the order in which they are written.
    pub(crate) const ALL: [Self; 17] = [
        Self::Id,
        Self::Start,
        Self::End,
        Self::Duration,
        Self::Conflict,
        Self::Priority,
        Self::Type,
        Self::Interval,
        Self::Memory,
        Self::Storage,
        Self::Power,
        Self::Draw,
        Self::Gap,
        Self::Cutoff,
        Self::Preempt,
        Self::Gates,
        Self::Args,
    ];

    /// The columns of the thesis, in its order: those of a file without a
    /// header.
    pub(crate) const THESIS: [Self; 9] = [
        Self::Id,
        Self::Start,
        Self::End,
        Self::Duration,
        Self::Conflict,
        Self::Priority,
        Self::Type,
        Self::Interval,
        Self::Args,
    ];

    /// Its name in the header.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Id => "id",
            Self::Start => "st",
            Self::End => "et",
            Self::Duration => "dur",
            Self::Conflict => "con",
            Self::Priority => "pri",
            Self::Type => "type",
            Self::Interval => "interval",
            Self::Memory => "memory",
            Self::Storage => "storage",
            Self::Power => "power",
            Self::Draw => "draw_w",
            Self::Gap => "gap",
            Self::Cutoff => "cutoff",
            Self::Preempt => "preempt",
            Self::Gates => "gates",
            Self::Args => "args",
        }
    }

    /// The column of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name() == name)
    }

    /// Whether each file has it.
    pub(crate) fn is_required(self) -> bool {
        Self::THESIS.contains(&self)
    }
}

/// A header as it stands in a file.
pub(crate) type Names<'a> = [(&'a str, Range<usize>)];

/// Whether a first line is a header: it names columns. One word alone may be a
/// task that is called so.
pub(crate) fn is_header<'a>(mut names: impl Iterator<Item = &'a str>) -> bool {
    names.by_ref().filter(|name| Column::named(name).is_some()).take(2).count() == 2
}

/// The columns that a header names. A place whose name nobody knows is told
/// and kept, so that the fields under it are not taken for others'.
pub(crate) fn header(names: &Names<'_>, report: &mut Report<'_>) -> Vec<Option<Column>> {
    let end = names.iter().rposition(|(name, _)| !name.is_empty()).map_or(0, |last| last + 1);
    let names = names.get(..end).unwrap_or_default();
    let mut columns: Vec<Option<Column>> = Vec::with_capacity(names.len());
    for (name, span) in names {
        let column = report.take(span.clone(), name, known(name, &columns));
        columns.push(column);
    }
    missing(names, &columns, report);
    columns
}

fn known(name: &str, before: &[Option<Column>]) -> Result<Column, Wrong> {
    match Column::named(name) {
        None => Err(unknown(name)),
        Some(column) if before.contains(&Some(column)) => {
            Err(Wrong::new(Rule::Duplicate, format!("the column {} is there twice", shown(name))))
        }
        Some(column) => Ok(column),
    }
}

fn unknown(name: &str) -> Wrong {
    let names = Column::ALL.map(Column::name);
    let wrong = Wrong::new(Rule::Unknown, format!("there is no column {}", shown(name)))
        .expected(names.join(", "));
    match suggest::nearest(name, names) {
        Some(near) => wrong.help(format!("did you mean {near}?")),
        None => wrong,
    }
}

/// A column that a name nobody knows may stand for is not missed as well.
fn missing(names: &Names<'_>, columns: &[Option<Column>], report: &mut Report<'_>) {
    let meant: Vec<_> = (names.iter().zip(columns))
        .filter(|(_, column)| column.is_none())
        .filter_map(|((name, _), _)| suggest::nearest(name, Column::ALL.map(Column::name)))
        .collect();
    let missed: Vec<_> = Column::THESIS
        .into_iter()
        .filter(|column| !columns.contains(&Some(*column)) && !meant.contains(&column.name()))
        .map(Column::name)
        .collect();
    if missed.is_empty() {
        return;
    }
    let end = names.last().map_or(0, |(_, span)| span.end);
    let message = format!("the header has no {}", missed.join(", "));
    let expected = Column::THESIS.map(Column::name).join(",");
    report.error(end..end, "", Wrong::new(Rule::Header, message).expected(expected));
}
