//! The part of `docs/performance.md` that is written by the benches.

use std::fs;
use std::path::Path;

use super::gather::Summary;
use super::machine;
use crate::support::{self, Failure};

const BEGIN: &str = "<!-- Written by ci/bench.sh --write; the rest of this page is not. -->";
const END: &str = "<!-- End of what ci/bench.sh writes. -->";

/// Replaces what is between the markers.
pub(crate) fn write(path: &Path, summary: &Summary, command: &str) -> Result<(), Failure> {
    let page = fs::read_to_string(path)?;
    let written = between(&page, &body(summary, command))
        .ok_or_else(|| format!("{} has not both markers: `{BEGIN}`, `{END}`", path.display()))?;
    fs::write(path, written)?;
    println!("written to {}", path.display());
    Ok(())
}

fn between(page: &str, body: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n\n{body}\n{END}{after}"))
}

fn body(summary: &Summary, command: &str) -> String {
    let mut body =
        format!("{}\n\n{}\n", machine::paragraph(command), support::figures(&summary.figures));
    for (row, name) in &summary.missing {
        body.push_str(&format!("\nRow {row}: {name}.\n"));
    }
    body.push_str("\nNanoseconds per operation of every entrant, for orientation:\n\n");
    body.push_str(&format!("{}\n", support::peers(&summary.peers)));
    for curve in &summary.curves {
        body.push_str(&format!("\n![{}]({}.svg)\n", curve.title, curve.slug));
    }
    body
}
