//! `items`: what promises constant time, and which row shows it.

use std::path::PathBuf;

use anyhow::Result;
use faregate_audit::items::{compare, promises};
use faregate_audit::rows::Rows;

use super::Verdict;

/// Compares and prints.
pub(super) fn items(rows: &Rows, sources: &[PathBuf], json: bool) -> Result<Verdict> {
    let promises = promises(sources)?;
    let disagreements = compare(rows, &promises);
    if json {
        let both = serde_json::json!({ "promises": promises, "disagreements": disagreements });
        println!("{}", serde_json::to_string_pretty(&both)?);
        return Ok(Verdict::of(disagreements.is_empty()));
    }
    for disagreement in &disagreements {
        println!("{disagreement}");
    }
    let (promised, apart) = (promises.len(), disagreements.len());
    println!("{promised} items promise constant time; rows and items disagree in {apart} places");
    Ok(Verdict::of(disagreements.is_empty()))
}
