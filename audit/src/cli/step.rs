//! `step`: random calls against the bounds.

use std::path::Path;

use anyhow::Result;
use comfy_table::{CellAlignment, Table, presets};
use faregate_audit::rows::Rows;
use faregate_audit::step::{Effort, Seen};

use super::{Object, Verdict};

/// Steps and prints.
pub(super) fn step(
    rows: &Rows,
    object: &Object,
    calls: u64,
    instructions: u64,
    json: bool,
) -> Result<Verdict> {
    let effort = Effort { calls, instructions };
    let seen = faregate_audit::step::step(rows, &object.read()?, &object.path, effort)?;
    let holds = seen.iter().all(|row| row.violations.is_empty());
    if json {
        println!("{}", serde_json::to_string_pretty(&seen)?);
        return Ok(Verdict::of(holds));
    }
    println!("{}", table(&seen));
    for row in &seen {
        row.violations.iter().for_each(|violation| println!("{}: {violation}", row.name));
    }
    for row in rows.rows.iter().filter(|row| !row.step) {
        println!("{}: not stepped: {}", row.name, row.step_why.as_deref().unwrap_or("?"));
    }
    let reached = seen.iter().filter(|row| row.most == row.bound).count();
    println!("{} functions stepped, {reached} of them up to their bound", seen.len());
    Ok(Verdict::of(holds))
}

fn table(seen: &[Seen]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY).set_header([
        "what",
        "calls",
        "most seen",
        "bound",
        "holds",
    ]);
    for row in seen {
        table.add_row([
            row.name.clone(),
            row.calls.to_string(),
            row.most.to_string(),
            row.bound.to_string(),
            if row.violations.is_empty() { "yes" } else { "NO" }.to_owned(),
        ]);
    }
    for column in [1, 2, 3] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// The child's side.
pub(super) fn host(path: &Path, symbol: &str, calls: u64) -> Result<Verdict> {
    faregate_audit::step::host(path, symbol, calls)?;
    Ok(Verdict::Holds)
}
