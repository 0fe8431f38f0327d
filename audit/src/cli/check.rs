//! `check`: the rows, and what breaks them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::Result;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use faregate_audit::findings::{Finding, find};
use faregate_audit::image::Image;
use faregate_audit::isa::Isa;
use faregate_audit::rows::Rows;
use faregate_audit::walk::{Outcome, Violation};

use super::Verdict;

/// Audits and prints.
pub(super) fn check(rows: &Rows, images: &BTreeMap<Isa, Image>, json: bool) -> Result<Verdict> {
    let findings = find(rows, images)?;
    let holds = findings.iter().all(Finding::holds);
    if json {
        println!("{}", serde_json::to_string_pretty(&findings)?);
        return Ok(Verdict::of(holds));
    }
    println!("{}", table(&findings));
    print!("{}", complaints(&findings));
    let broken = findings.iter().filter(|finding| !finding.holds()).count();
    for (isa, image) in images {
        println!("{}: {}", isa.title(), image.compiler);
    }
    println!("{} rows audited, {broken} of them broken", findings.len());
    Ok(Verdict::of(holds))
}

/// What most terminals have room for, and logs too.
const WIDTH: u16 = 140;

fn table(findings: &[Finding]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH).set_header([
        "what",
        "on",
        "instructions",
        "locked",
        "stack",
        "loops",
        "holds",
    ]);
    for finding in findings {
        for (isa, found) in &finding.outcomes {
            table.add_row([
                finding.name.clone(),
                isa.title().to_owned(),
                found.instructions.to_string(),
                found.locked.to_string(),
                found.stack.to_string(),
                loops(found),
                if found.violations.is_empty() { "yes" } else { "NO" }.to_owned(),
            ]);
        }
    }
    for column in [2, 3, 4] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn loops(found: &Outcome) -> String {
    let last = |path: &str| path.rsplit("::").next().unwrap_or_default().to_owned();
    let loops =
        found.loops.iter().map(|(owner, most, why)| format!("{}: {most} {why}", last(owner)));
    loops.collect::<Vec<_>>().join("; ")
}

/// What is wrong, and where.
fn complaints(findings: &[Finding]) -> String {
    let mut text = String::new();
    for finding in findings {
        for idle in &finding.idle {
            let _ = writeln!(text, "{}: not as its row says: {idle}", finding.name);
        }
        for (isa, found) in &finding.outcomes {
            for violation in &found.violations {
                let _ = writeln!(text, "{} on {}: {}", finding.name, isa.title(), told(violation));
            }
        }
    }
    text
}

pub(super) fn told(violation: &Violation) -> String {
    let Violation { kind, place, text, source, detail } = violation;
    let mut told = format!("[{kind}] {detail}\n    at {place}: {text}");
    for frame in source {
        let _ = write!(told, "\n      in {frame}");
    }
    told
}
