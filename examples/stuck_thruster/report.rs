//! What is printed: the timeline of one run, and the table of all.

use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, presets};

use crate::campaign::{Campaign, Row};
use crate::stage::Line;

/// The timeline of one run.
pub(crate) fn timeline(story: &[Line]) -> String {
    let line = |line: &Line| {
        let ms = line.at.as_micros() / 1_000;
        format!("{:>8} ms  {:<14} {}", ms, line.who, line.what)
    };
    story.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The table of all designs.
pub(crate) fn table(campaign: &Campaign) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING.header_separator(LineStyle::none().fill('-').junction('-')));
    table.set_content_arrangement(ContentArrangement::Disabled);
    table.set_header([
        "design\n",
        "runs\n",
        "lost\n",
        "by which\nlaw",
        "commands after\nquiescence",
        "valid\nrefused",
        "cutoffs\nactuated",
        "observations\nrestored",
        "worst\ncutoff",
        "its\nbound",
    ]);
    for row in &campaign.designs {
        table.add_row(cells(row));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}

fn cells(row: &Row) -> [String; 10] {
    let laws: Vec<_> = row.lost_by.iter().map(|(law, lost)| format!("{law} {lost}")).collect();
    let ms = |time: Option<f64>| time.map_or("-".into(), |ms| format!("{ms:.1} ms"));
    [
        row.name.into(),
        row.runs.to_string(),
        row.lost.to_string(),
        if laws.is_empty() { "-".into() } else { laws.join("\n") },
        row.commands_after_quiescence.to_string(),
        row.valid_refused.to_string(),
        row.cutoffs_actuated.to_string(),
        format!("{}/{}", row.restored, row.restorable),
        ms(row.worst_cutoff_ms),
        ms(row.bound_of_worst_ms),
    ]
}

/// What the table does not show.
pub(crate) fn remarks(campaign: &Campaign) -> String {
    let windows: Vec<_> = campaign
        .convention_by_window_ms
        .iter()
        .map(|(width, runs, lost)| format!("{width} ms: {lost} of {runs}"))
        .collect();
    format!(
        "With nobody who keeps the camera on, the three rivals lose {} of {} spacecraft.\n\
         Allocations by convention lose, by the width of the window between check and command: {}.",
        campaign.rivals_lost_without_monitor,
        campaign.designs.first().map_or(0, |row| row.runs) * 3,
        windows.join(", "),
    )
}
