//! Tables of what was found.

use comfy_table::{CellAlignment, Table, presets};
use serde_json::Value;

use super::{Figure, Peer};

fn table(header: &[&str], right: &[usize]) -> Table {
    let mut table = Table::new();
    // The same characters as a table in Markdown: it can be quoted as it is.
    table.load_style(presets::ASCII_MARKDOWN).set_header(header.to_vec());
    for &column in right {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// Every figure, and how it stands to its target.
pub(crate) fn figures<'a>(figures: impl IntoIterator<Item = &'a Figure>) -> Table {
    let mut table = table(&["row", "figure", "value", "target", "met"], &[0, 2, 3]);
    for figure in figures {
        table.add_row([
            figure.row.map(|row| row.to_string()).unwrap_or_default(),
            figure.name.clone(),
            format!("{} {}", number(figure.value), figure.unit),
            target(&figure.target),
            met(figure.met).to_owned(),
        ]);
    }
    table
}

fn target(target: &Value) -> String {
    match target {
        Value::Number(limit) => {
            format!("<= {}", limit.as_f64().map_or_else(|| limit.to_string(), number))
        }
        Value::String(words) => words.clone(),
        _ => String::new(),
    }
}

fn met(met: Option<bool>) -> &'static str {
    match met {
        Some(true) => "yes",
        Some(false) => "NO",
        None => "",
    }
}

/// Every entrant of every contest.
pub(crate) fn peers<'a>(peers: impl IntoIterator<Item = &'a Peer>) -> Table {
    let header = ["contest", "entrant", "5th percentile, ns", "median, ns"];
    let mut table = table(&header, &[2, 3]);
    for peer in peers {
        let [p5, median] = [peer.p5_ns, peer.median_ns].map(number);
        table.add_row([peer.contest.clone(), peer.name.clone(), p5, median]);
    }
    table
}

/// Three digits that mean something, and whole numbers whole.
pub(crate) fn number(value: f64) -> String {
    match value {
        v if v.fract() == 0.0 && v.abs() < 1e15 => format!("{v:.0}"),
        v if v.abs() >= 100.0 => format!("{v:.0}"),
        v if v.abs() >= 10.0 => format!("{v:.1}"),
        v => format!("{v:.2}"),
    }
}
