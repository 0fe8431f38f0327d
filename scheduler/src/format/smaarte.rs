//! SMAARTE's files: rows and columns as drafts of tasks.

use core::ops::Range;

use crate::format::body;
use crate::format::columns::{self, Column};
use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::policy;
use crate::format::rows::{self, Cell, Row};
use crate::format::scalar::{self, Conflict};
use crate::format::words::{self, Words};
use crate::format::wrong::{Report, Wrong};
use crate::task::{Body, Preemption};

/// The drafts of a file with commas.
pub(crate) fn csv(report: &mut Report<'_>, conflict: Conflict) -> Vec<Draft> {
    let mut rows = rows::of_csv(report).into_iter().peekable();
    let first = rows.next_if(|row| columns::is_header(names(row)));
    let columns = match (first, rows.peek()) {
        (Some(header), _) => header_of(&header, report),
        (None, row) => {
            let at = row.map_or(0..0, Row::at);
            report.error(at.clone(), "", no_header(report.source.slice(at)));
            Column::THESIS.map(Some).to_vec()
        }
    };
    drafts(rows, Reading { report, conflict, columns: &columns })
}

fn drafts(rows: impl Iterator<Item = Row>, mut reading: Reading<'_, '_>) -> Vec<Draft> {
    let mut drafts = Vec::new();
    for row in rows {
        if reading.report.is_enough(drafts.len(), row.at()) {
            break;
        }
        drafts.push(reading.draft(&row));
    }
    drafts
}

/// The drafts of a file with spaces, which may have a header.
pub(crate) fn txt(report: &mut Report<'_>, conflict: Conflict) -> Vec<Draft> {
    let first = rows::of_txt(report.source, usize::MAX).into_iter().next();
    let header = first.filter(|row| columns::is_header(names(row)));
    let columns = match &header {
        Some(header) => header_of(header, report),
        None => Column::THESIS.map(Some).to_vec(),
    };
    args_last(&columns, header.as_ref(), report);
    let rows = rows::of_txt(report.source, columns.len().saturating_sub(1));
    let rows = rows.into_iter().skip(header.iter().count());
    drafts(rows, Reading { report, conflict, columns: &columns })
}

fn names(row: &Row) -> impl Iterator<Item = &str> {
    row.cells.iter().map(|cell| cell.text.as_str())
}

fn header_of(header: &Row, report: &mut Report<'_>) -> Vec<Option<Column>> {
    let names: Vec<_> =
        header.cells.iter().map(|cell| (cell.text.as_str(), cell.at.clone())).collect();
    columns::header(&names, report)
}

fn no_header(first: &str) -> Wrong {
    let wrong = Wrong::new(Rule::Header, "the first line names no columns")
        .expected(Column::THESIS.map(Column::name).join(","));
    if first.contains(';') || first.contains('\t') {
        return wrong.help("columns are separated by commas: save the file with commas");
    }
    wrong.help("a file without a header is a TXT file, with spaces between the fields")
}

fn args_last(columns: &[Option<Column>], header: Option<&Row>, report: &mut Report<'_>) {
    let at = columns.iter().position(|column| *column == Some(Column::Args));
    let cell = header.zip(at).and_then(|(header, at)| header.cells.get(at));
    if let Some(cell) = cell
        && at != Some(columns.len() - 1)
    {
        let wrong = Wrong::new(Rule::Header, "args is the rest of the line, and stands last");
        report.error(cell.at.clone(), "args", wrong);
    }
}

/// What a row is read with.
struct Reading<'a, 'b> {
    report: &'a mut Report<'b>,
    conflict: Conflict,
    columns: &'a [Option<Column>],
}

impl Reading<'_, '_> {
    fn draft(&mut self, row: &Row) -> Draft {
        let mut draft = Draft::new(row.at());
        let complete = self.check_length(row);
        for (column, cell) in self.columns.iter().zip(&row.cells) {
            if let Some(column) = column
                && !matches!(column, Column::Type | Column::Args)
            {
                let good = cell.good && self.read(*column, cell, &mut draft);
                draft.note(column.name(), cell.at.clone(), good);
            }
        }
        self.body(row, &mut draft, complete);
        self.pre_emption(row, &mut draft);
        draft
    }

    fn cell<'c>(&self, row: &'c Row, column: Column) -> Option<&'c Cell> {
        let at = self.columns.iter().position(|known| *known == Some(column))?;
        row.cells.get(at)
    }

    /// Reads a field into the draft; whether it could be read.
    fn read(&mut self, column: Column, cell: &Cell, draft: &mut Draft) -> bool {
        let text = cell.text.as_str();
        if text.is_empty() && !column.is_required() {
            return true;
        }
        let task = &mut draft.task;
        let window = task.windows.first_mut();
        let done = match column {
            Column::Id => scalar::task_id(text).map(|id| draft.id = Some(id)),
            Column::Start => scalar::when(text).map(|when| {
                window.into_iter().for_each(|window| window.opens = when);
            }),
            Column::End => scalar::when(text).map(|when| {
                window.into_iter().for_each(|window| window.closes = when);
            }),
            Column::Duration => scalar::seconds(text).map(|time| task.duration = time),
            Column::Conflict => {
                scalar::categories(text, self.conflict).map(|mask| task.categories = mask)
            }
            Column::Priority => scalar::priority(text).map(|level| task.priority = level),
            Column::Interval => scalar::seconds(text)
                .map(|time| task.interval = Some(time).filter(|time| !time.is_zero())),
            Column::Memory => scalar::bytes(text).map(|bytes| task.memory = bytes),
            Column::Storage => scalar::bytes(text).map(|bytes| task.storage = bytes),
            Column::Power => scalar::percent(text).map(|percent| task.battery = percent),
            Column::Draw => scalar::watts(text).map(|draw| {
                (task.peak_draw, task.average_draw) = (draw, draw);
            }),
            Column::Gap => scalar::seconds(text).map(|time| task.gap = time),
            Column::Cutoff => scalar::when(text).map(|when| task.cutoff = when),
            Column::Gates => gates(text).map(|gates| task.gates = gates),
            Column::Type | Column::Args | Column::Preempt => Ok(()),
        };
        self.report.take(cell.at.clone(), column.name(), done).is_some()
    }

    /// Of a row that ends early nothing more is said.
    fn body(&mut self, row: &Row, draft: &mut Draft, complete: bool) {
        let number = self.number(row, draft);
        let end = row.at().end;
        let (line, at, good) = self
            .cell(row, Column::Args)
            .map_or(("", end..end, true), |cell| (&cell.text, cell.at.clone(), cell.good));
        let body = if good && complete { self.arguments(number, line, &at) } else { None };
        draft.note("args", at, body.is_some());
        if let Some(body) = body {
            draft.task.preemption = policy::usual(&body);
            draft.task.body = body;
        }
    }

    fn number(&mut self, row: &Row, draft: &mut Draft) -> Option<u16> {
        let cell = self.cell(row, Column::Type)?;
        let number = scalar::type_number(&cell.text)
            .and_then(|number| body::check_type(number).map(|()| number));
        let number =
            if cell.good { self.report.take(cell.at.clone(), "type", number) } else { None };
        draft.note("type", cell.at.clone(), number.is_some());
        number
    }

    /// Arguments are words whatever the type is; what they mean needs it.
    fn arguments(&mut self, number: Option<u16>, line: &str, at: &Range<usize>) -> Option<Body> {
        let Words { words, warning } = self.report.take(at.clone(), "args", words::split(line))?;
        if let Some(warning) = warning {
            self.report.warn(at.clone(), "args", warning);
        }
        self.report.take(at.clone(), "args", body::from_type(number?, words))
    }

    /// After the body, which says what can be.
    fn pre_emption(&mut self, row: &Row, draft: &mut Draft) {
        let Some(cell) = self.cell(row, Column::Preempt).filter(|cell| cell.good) else { return };
        if cell.text.is_empty() {
            return;
        }
        let read = policy::pre_emption(&cell.text);
        let read: Option<Preemption> = self.report.take(cell.at.clone(), "preempt", read);
        draft.note("preempt", cell.at.clone(), read.is_some());
        if let Some(preemption) = read {
            draft.task.preemption = preemption;
        }
    }

    /// Whether nothing is missing.
    fn check_length(&mut self, row: &Row) -> bool {
        let more = row.cells.get(self.columns.len()..).unwrap_or_default();
        if let Some(extra) = more.iter().find(|cell| !cell.text.is_empty() || !cell.good) {
            let end = more.last().map_or(extra.at.end, |last| last.at.end);
            self.report.error(extra.at.start..end, "", extra_fields(row, self.columns.len()));
        }
        let cut = self.columns.get(row.cells.len()..).unwrap_or_default();
        let missing: Vec<_> = cut.iter().flatten().filter(|column| is_missed(**column)).collect();
        if !missing.is_empty() {
            let names: Vec<_> = missing.iter().map(|column| column.name()).collect();
            let message = format!("the row ends before {}", names.join(", "));
            let expected = format!("{} fields", self.columns.len());
            let end = row.at().end;
            self.report.error(end..end, "", Wrong::new(Rule::Missing, message).expected(expected));
        }
        missing.is_empty()
    }
}

/// Names between semicolons, which need no quotes in either format, or spaces;
/// `-` where there are none, since a file with spaces has no empty field.
fn gates(text: &str) -> Result<Vec<String>, Wrong> {
    if text == "-" {
        return Ok(Vec::new());
    }
    let names = text.split([';', ' ']).filter(|name| !name.is_empty());
    match names.map(str::to_owned).collect::<Vec<_>>() {
        none if none.is_empty() => Err(Wrong::new(Rule::Value, "there is no name")
            .expected("names of gates, as in camera;gimbal, or -")),
        names => Ok(names),
    }
}

/// Some spreadsheets drop empty cells at the end of a row, so only what cannot
/// be empty is missed.
fn is_missed(column: Column) -> bool {
    column.is_required() && column != Column::Args
}

fn extra_fields(row: &Row, columns: usize) -> Wrong {
    let message = format!("{} fields under {columns} columns", row.cells.len());
    Wrong::new(Rule::ExtraFields, message)
        .expected(format!("{columns} fields"))
        .help("put arguments that have a comma in them in quotes: \"take 1,2\"")
}
