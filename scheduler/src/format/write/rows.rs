//! SMAARTE's files, written.

use faregate_agents::Categories;

use crate::format::columns::Column;
use crate::format::write::text;
use crate::format::{Kind, body, policy};
use crate::task::{Task, Window};

/// Why there is no row for a task, if there is none.
pub(crate) fn why_not(kind: Kind, task: &Task) -> Option<String> {
    if kind == Kind::Toml {
        return None;
    }
    let Some((_, words)) = body::to_type(&task.body) else {
        return Some("left out: a sequence has no type".to_owned());
    };
    let line = body::line(&words);
    let breaks = line.is_none_or(|line| kind == Kind::Txt && line.contains(['\n', '\r']));
    breaks.then(|| "left out: an argument has a line break or a NUL in it".to_owned())
}

/// The file with commas.
pub(crate) fn csv(tasks: &[&Task]) -> String {
    let columns = columns(tasks);
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Neither a Vec nor equally long records can fail.
    let _ = writer.write_record(columns.iter().map(|column| column.name()));
    for task in tasks {
        let _ = writer.write_record(columns.iter().map(|column| field(*column, task)));
    }
    writer.into_inner().ok().and_then(|text| String::from_utf8(text).ok()).unwrap_or_default()
}

/// The file with spaces; with a header only where it has more columns than
/// SMAARTE's.
pub(crate) fn txt(tasks: &[&Task]) -> String {
    let columns = columns(tasks);
    let mut text = String::new();
    if columns != Column::THESIS {
        line(&mut text, columns.iter().map(|column| column.name().to_owned()));
    }
    for task in tasks {
        line(&mut text, columns.iter().map(|column| field(*column, task)));
    }
    text
}

fn line(text: &mut String, fields: impl Iterator<Item = String>) {
    let line = fields.collect::<Vec<_>>().join(" ");
    text.push_str(line.trim_ascii_end());
    text.push('\n');
}

/// The thesis's columns, and those of ours that some task needs.
fn columns(tasks: &[&Task]) -> Vec<Column> {
    let needed =
        |column: &Column| column.is_required() || tasks.iter().any(|task| is_stated(*column, task));
    Column::ALL.into_iter().filter(needed).collect()
}

/// Whether an optional column is not at its default.
fn is_stated(column: Column, task: &Task) -> bool {
    match column {
        Column::Memory => task.memory > 0,
        Column::Storage => task.storage > 0,
        Column::Power => task.battery > 0,
        Column::Draw => !task.peak_draw.is_zero(),
        Column::Gap => !task.gap.is_zero(),
        Column::Cutoff => task.cutoff != crate::task::When::Unrestricted,
        Column::Preempt => task.preemption != policy::usual(&task.body),
        Column::Gates => gates(task).is_some(),
        _ => true,
    }
}

fn field(column: Column, task: &Task) -> String {
    let Window { opens, closes } = task.windows.first().copied().unwrap_or_default();
    match column {
        Column::Id => task.id.get().to_string(),
        Column::Start => text::when(opens),
        Column::End => text::when(closes),
        Column::Duration => text::seconds(task.duration),
        Column::Conflict if task.categories == Categories::ALL => "all".to_owned(),
        Column::Conflict => task.categories.mask().to_string(),
        Column::Priority => task.priority.level().to_string(),
        Column::Type => body::to_type(&task.body).map_or(0, |(number, _)| number).to_string(),
        Column::Interval => text::seconds(task.interval.unwrap_or_default()),
        Column::Memory => task.memory.to_string(),
        Column::Storage => task.storage.to_string(),
        Column::Power => task.battery.to_string(),
        Column::Draw => text::watts(task.peak_draw),
        Column::Gap => text::seconds(task.gap),
        Column::Cutoff => text::when(task.cutoff),
        Column::Preempt => policy::column(task.preemption, text::seconds),
        Column::Gates => gates(task).unwrap_or_else(|| "-".to_owned()),
        Column::Args => {
            body::to_type(&task.body).and_then(|(_, words)| body::line(&words)).unwrap_or_default()
        }
    }
}

/// The names of its gates, if there are any and each can stand in a row.
fn gates(task: &Task) -> Option<String> {
    let plain = |byte: u8| byte.is_ascii_graphic() && !b";,\"'\\".contains(&byte);
    let stands = |name: &String| !name.is_empty() && name != "-" && name.bytes().all(plain);
    let all = !task.gates.is_empty() && task.gates.iter().all(stands);
    all.then(|| task.gates.join(";"))
}
