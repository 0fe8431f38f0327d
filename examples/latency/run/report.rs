//! What is printed.

use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, presets};

use super::results::Played;
use super::rows::Case;

/// A table of the rows of one case, under its title; nothing where none was
/// played.
pub(crate) fn table(case: Case, played: &[Played]) -> Option<String> {
    let rows: Vec<_> = played.iter().filter(|row| row.case == case).collect();
    if rows.is_empty() {
        return None;
    }
    let mut table = Table::new();
    table.load_style(presets::NOTHING.header_separator(LineStyle::none().fill('-').junction('-')));
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header([
        "",
        "CPUs",
        "rounds",
        "caught\ninside",
        "hog\nfirst",
        "p50\nus",
        "p99\nus",
        "p99.9\nus",
        "max\nus",
        "target\np99",
        "after\nquiescence",
    ]);
    for row in rows {
        table.add_row(cells(row));
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    Some(format!("{}\n{}", case.title(), table.trim_fmt()))
}

fn cells(row: &Played) -> [String; 11] {
    let measured = &row.measured;
    let none = || "-".to_owned();
    let time = |us: Option<f64>| match us {
        _ if row.never() => "never".into(),
        // Nanoseconds, as long as they mean something.
        Some(us) if us < 1.0 => format!("{us:.3}"),
        Some(us) => format!("{us:.1}"),
        None => none(),
    };
    let if_told = |told: bool, count: u64| if told { count.to_string() } else { none() };
    [
        row.who.into(),
        row.placement.name().into(),
        measured.rounds().to_string(),
        if_told(row.tells_caught(), measured.caught),
        if_told(row.case != Case::WakeUp, measured.hog_first),
        time(measured.quantile_us(0.5)),
        time(measured.quantile_us(0.99)),
        time(measured.quantile_us(0.999)),
        time(Some(measured.max_us())),
        row.target_us.map_or_else(none, |us| format!("<= {us}")),
        if_told(row.tells_late() && !row.never(), measured.late),
    ]
}
