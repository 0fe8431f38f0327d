//! A task of the native format.

use core::ops::Range;
use std::collections::BTreeMap;

use faregate_agents::Categories;
use toml::de::{DeTable, DeValue};

use crate::format::check;
use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::native::table::Table;
use crate::format::native::value::{self, set, word};
use crate::format::native::{keys, policies, steps};
use crate::format::scalar;
use crate::format::wrong::{Report, Wrong};
use crate::task::{Dependency, Spread, Status, Window};
use crate::time::Duration;

/// The names that a task can use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names<'a> {
    /// Categories; none: there is no mission.
    pub(crate) of_categories: Option<&'a BTreeMap<String, u8>>,
    /// Whether there are no others that could not be read.
    pub(crate) complete: bool,
}

/// Reads a task.
pub(crate) fn read(
    table: &DeTable<'_>,
    at: Range<usize>,
    names: Names<'_>,
    report: &mut Report<'_>,
) -> Draft {
    let mut draft = Draft::new(at.clone());
    let before = report.found.len();
    let mut table = Table::new(table, at, "", report);
    steps::body(&mut table, &mut draft);
    what(&mut table, &mut draft);
    when(&mut table, &mut draft);
    needs(&mut table, &mut draft, names);
    policies::read(&mut table, &mut draft);
    others(&mut table, &mut draft);
    note_fields(&table, &mut draft, before);
    table.finish(keys::TASK);
    draft
}

/// Where each field stands, and whether something was told of it.
fn note_fields(table: &Table<'_, '_, '_>, draft: &mut Draft, before: usize) {
    for key in table.present(keys::TASK) {
        let told = table.report.found.iter().skip(before).filter(|wrong| wrong.is_error());
        let good = told.clone().all(|wrong| wrong.field.as_deref() != Some(key));
        draft.note(key, table.span(key), good);
    }
}

fn what(table: &mut Table<'_, '_, '_>, draft: &mut Draft) {
    draft.id = table.need("id", value::number("a task number, 1 to 4294967295", scalar::task_id));
    draft.task.name = table.read("name", value::name);
    let priority = value::number("a priority, 0 to 239", scalar::priority);
    set(&mut draft.task.priority, table.read("pri", priority));
    set(&mut draft.task.mandatory, table.read("mandatory", value::truth));
}

fn when(table: &mut Table<'_, '_, '_>, draft: &mut Draft) {
    let task = &mut draft.task;
    if let Some(windows) = windows(table) {
        task.windows = windows;
    }
    set(&mut task.cutoff, table.read("cutoff", value::when));
    set(&mut task.duration, table.read("dur", value::duration));
    let interval = table.read("interval", value::duration);
    task.interval = interval.filter(|interval| !interval.is_zero());
    let shortest = table.read("dur_min", value::duration);
    let longest = table.read("dur_max", value::duration);
    if table.value("dur_min").or(table.value("dur_max")).is_some() {
        // An end that is not given is the usual duration.
        let shortest = shortest.unwrap_or(task.duration);
        task.spread = Some(Spread { shortest, longest: longest.unwrap_or(task.duration) });
    }
    task.heartbeat = table.read("heartbeat", positive);
    set(&mut task.gap, table.read("gap", value::duration));
}

fn positive(value: &DeValue<'_>) -> Result<Duration, Wrong> {
    let duration = value::duration(value)?;
    if duration.is_zero() {
        return Err(Wrong::new(Rule::Range, "this is no time at all").expected("more than 0"));
    }
    Ok(duration)
}

/// One window, or several; each is judged where it stands.
fn windows(table: &mut Table<'_, '_, '_>) -> Option<Vec<Window>> {
    let several = table.tables("window");
    if table.value("window").is_none() {
        let opens = table.read("st", value::when).unwrap_or_default();
        return Some(vec![Window {
            opens,
            closes: table.read("et", value::when).unwrap_or_default(),
        }]);
    }
    for key in table.present(&["st", "et"]) {
        let wrong = Wrong::new(Rule::Duplicate, format!("{key} and window exclude each other"));
        table.error(table.span(key), key, wrong.help("put it into a window of its own"));
    }
    if several.is_empty() && matches!(table.value("window"), Some((DeValue::Array(_), _))) {
        let wrong = Wrong::new(Rule::Missing, "there is no window").expected("at least one");
        table.error(table.span("window"), "window", wrong);
    }
    let all = several.into_iter().map(|(one, at)| window(one, at, table.report));
    all.collect::<Vec<_>>().into_iter().collect()
}

fn window(table: &DeTable<'_>, at: Range<usize>, report: &mut Report<'_>) -> Option<Window> {
    let mut table = Table::new(table, at, "window.", report);
    let opens = table.value("st").map(|_| table.read("st", value::when));
    let closes = table.value("et").map(|_| table.read("et", value::when));
    let window = Window {
        opens: opens.unwrap_or(Some(Default::default()))?,
        closes: closes.unwrap_or(Some(Default::default()))?,
    };
    let judged = check::window(window);
    let span = table.span("et");
    let field = table.field("et");
    table.report.take(span, &field, judged)?;
    table.finish(keys::WINDOW);
    Some(window)
}

fn needs(table: &mut Table<'_, '_, '_>, draft: &mut Draft, names: Names<'_>) {
    let task = &mut draft.task;
    set(&mut task.categories, categories(table, "con", names));
    set(&mut task.memory, table.read("memory", value::size));
    set(&mut task.storage, table.read("storage", value::size));
    set(&mut task.data, table.read("data", value::size));
    set(
        &mut task.battery,
        table.read("power", value::number("a percentage, 0 to 100", scalar::percent)),
    );
    set(&mut task.peak_draw, table.read("draw_w", value::watts));
    task.average_draw = table.read("average_draw_w", value::watts).unwrap_or(task.peak_draw);
    if table.value("average_draw_w").is_some() && task.average_draw > task.peak_draw {
        let wrong = Wrong::new(Rule::Range, "the average is larger than the largest draw");
        table.error(
            table.span("average_draw_w"),
            "average_draw_w",
            wrong.expected("at most draw_w"),
        );
    }
}

/// A mask, `all`, or an array of names and numbers of categories.
pub(crate) fn categories(
    table: &mut Table<'_, '_, '_>,
    key: &'static str,
    names: Names<'_>,
) -> Option<Categories> {
    match table.value(key)?.0 {
        DeValue::Array(_) => {
            let each = table.list(key, |value| category(value, names))?;
            Some(each.into_iter().fold(Categories::NONE, Categories::union))
        }
        DeValue::String(_) => table.read(key, |value| {
            let text = value::text(value)?;
            if text == "all" || text.starts_with(|first: char| first.is_ascii_digit()) {
                return scalar::categories(text, scalar::Conflict::Mask);
            }
            category(value, names)
        }),
        _ => table.read(key, |value| {
            let digits = value::digits(value, "a mask, all, or an array of categories")?;
            scalar::categories(&digits, scalar::Conflict::Mask)
        }),
    }
}

fn category(value: &DeValue<'_>, names: Names<'_>) -> Result<Categories, Wrong> {
    let DeValue::String(name) = value else {
        let digits = value::digits(value, "the name or the number of a category")?;
        return scalar::category(&digits).map(|bit| Categories::from_mask(1 << bit));
    };
    let known = names.of_categories.into_iter().flatten();
    match known.clone().find(|(known, _)| *known == name) {
        Some((_, bit)) => Ok(Categories::from_mask(1 << bit.min(&127))),
        None if !names.complete => Ok(Categories::NONE),
        None => Err(check::no_such("category", name, known.map(|(known, _)| known.as_str()))),
    }
}

fn others(table: &mut Table<'_, '_, '_>, draft: &mut Draft) {
    let cleanup = value::number("the number of a task", scalar::task_id);
    draft.task.cleanup = table.read("cleanup", cleanup);
    let Some(items) = table.items("after") else { return };
    for (item, at) in items {
        draft.task.after.extend(dependency(item, at, table));
    }
}

/// A number alone means that the other task has succeeded.
fn dependency(
    value: &DeValue<'_>,
    at: Range<usize>,
    table: &mut Table<'_, '_, '_>,
) -> Option<Dependency> {
    let number = value::number("the number of a task", scalar::task_id);
    let DeValue::Table(inner) = value else {
        let task = table.report.take(at, "after", number(value))?;
        return Some(Dependency { task, status: Status::Succeeded });
    };
    let mut inner = Table::new(inner, at, "after.", table.report);
    let task = inner.need("task", number);
    let status = match inner.value("status") {
        Some(_) => inner.read("status", |value| word(value, &STATUSES)),
        None => Some(Status::Succeeded),
    };
    inner.finish(keys::AFTER);
    Some(Dependency { task: task?, status: status? })
}

/// The outcomes that satisfy a dependant, by name.
pub(crate) const STATUSES: [(&str, Status); 6] = [
    ("succeeded", Status::Succeeded),
    ("failed", Status::Failed),
    ("aborted", Status::Aborted),
    ("missed", Status::Missed),
    ("completed", Status::Completed),
    ("finished", Status::Finished),
];
