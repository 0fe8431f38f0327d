//! `reject`: what must be rejected is, and for its own reason.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use comfy_table::{Table, presets};
use faregate_audit::findings::find;
use faregate_audit::image::Image;
use faregate_audit::isa::Isa;
use faregate_audit::rows::Rows;

use super::Verdict;
use super::check::told;

/// Audits and prints.
pub(super) fn reject(rows: &Rows, images: &BTreeMap<Isa, Image>) -> Result<Verdict> {
    let findings = find(rows, images)?;
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY).set_header([
        "what",
        "on",
        "has to be",
        "is",
        "holds",
    ]);
    for finding in &findings {
        for (isa, found) in &finding.outcomes {
            table.add_row([
                finding.name.clone(),
                isa.title().to_owned(),
                verdict(&finding.rejected),
                verdict(&found.kinds()),
                if found.kinds() == finding.rejected { "yes" } else { "NO" }.to_owned(),
            ]);
        }
    }
    println!("{table}");
    let mistaken: Vec<_> = findings.iter().filter(|finding| !finding.holds()).collect();
    for finding in &mistaken {
        finding.idle.iter().for_each(|idle| println!("{}: {idle}", finding.name));
        let all = finding.outcomes.values().flat_map(|found| &found.violations);
        all.for_each(|violation| println!("{}: {}", finding.name, told(violation)));
    }
    println!("{} functions judged, {} of them wrongly", findings.len(), mistaken.len());
    Ok(Verdict::of(mistaken.is_empty()))
}

fn verdict(kinds: &BTreeSet<String>) -> String {
    if kinds.is_empty() {
        return "accepted".to_owned();
    }
    kinds.iter().cloned().collect::<Vec<_>>().join(", ")
}
