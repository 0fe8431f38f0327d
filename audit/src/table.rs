//! The table in `docs/timing.md`, between two markers.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use anyhow::{Context as _, Result};
use similar::TextDiff;

use crate::findings::Finding;
use crate::image::Image;
use crate::isa::Isa;
use crate::walk::Outcome;

const BEGIN: &str = "<!-- audit:begin -->";
const END: &str = "<!-- audit:end -->";
/// What the line with the compilers begins with.
const COMPILED: &str = "Compiled by ";

/// Of so many loops each is told by name.
const LOOPS_TOLD: usize = 6;

/// A document's table, beside the one that the audit finds.
#[derive(Debug, PartialEq, Eq)]
pub enum Comparison {
    /// They are the same.
    Same,
    /// They come from different compilers: other instructions, other counts.
    OtherCompiler {
        /// The document's.
        document: String,
        /// This audit's.
        here: String,
    },
    /// They differ, and this is how.
    Different(String),
}

/// The table.
pub fn markdown(findings: &[Finding], images: &BTreeMap<Isa, Image>) -> String {
    let compilers: Vec<_> = images
        .iter()
        .map(|(isa, image)| format!("{} (for {})", image.compiler, isa.title()))
        .collect();
    let mut text = format!("{COMPILED}{}.\n", compilers.join(", "));
    let mut group = None;
    for finding in findings {
        if group != Some(&finding.group) {
            group = Some(&finding.group);
            heading(&mut text, &finding.group, images);
        }
        let _ =
            writeln!(text, "| {} |{} {} |", finding.name, figures(finding, images), with(finding));
    }
    text
}

fn heading(text: &mut String, group: &str, images: &BTreeMap<Isa, Image>) {
    if !group.is_empty() {
        let _ = write!(text, "\n### {group}\n");
    }
    let _ = write!(text, "\n| what |");
    for isa in images.keys() {
        let _ = write!(text, " {}: instructions | locked | stack |", isa.title());
    }
    let _ = write!(text, " with |\n|---|");
    for _ in images.keys() {
        let _ = write!(text, "---:|---:|---:|");
    }
    let _ = writeln!(text, "---|");
}

fn figures(finding: &Finding, images: &BTreeMap<Isa, Image>) -> String {
    let one = |isa: &Isa| match finding.outcomes.get(isa) {
        Some(found) => format!(" {} | {} | {} |", found.instructions, found.locked, found.stack),
        None => " | | |".to_owned(),
    };
    images.keys().map(one).collect()
}

/// What is on the paths beside instructions: said once where it is the same
/// for each instruction set.
fn with(finding: &Finding) -> String {
    let each: BTreeMap<_, _> =
        finding.outcomes.iter().map(|(isa, found)| (*isa, remarks(found))).collect();
    let all: BTreeSet<_> = each.values().flatten().cloned().collect();
    let said = all.into_iter().map(|remark| {
        let has = |isa: &Isa| each.get(isa).is_some_and(|remarks| remarks.contains(&remark));
        let on: Vec<_> = each.keys().filter(|isa| has(isa)).map(|isa| isa.title()).collect();
        if on.len() == each.len() { remark } else { format!("{}: {remark}", on.join(", ")) }
    });
    said.collect::<Vec<_>>().join("; ")
}

fn remarks(found: &Outcome) -> BTreeSet<String> {
    let mut remarks = BTreeSet::from_iter(loops(found));
    if let Some(bytes) = found.copies {
        remarks.insert(format!("copies of {bytes} bytes at most"));
    }
    let calls = found.system_calls.iter().map(|name| format!("system call `{name}`"));
    let outside = found.external.iter().map(|name| format!("calls `{name}`, not counted"));
    let cold = found.cold.iter().map(|name| format!("`{}`: a row of its own", short(name)));
    let port = found.port.iter().map(|why| format!("port, not counted: {why}"));
    remarks.extend(calls.chain(outside).chain(cold).chain(port));
    remarks.extend(found.excused.iter().cloned());
    remarks
}

/// Each loop with its bound; where there are many, the bounds that they have.
fn loops(found: &Outcome) -> Vec<String> {
    let many = found.loops.len() > LOOPS_TOLD;
    if many {
        let bounds: BTreeSet<_> =
            found.loops.iter().map(|(_, most, why)| format!("{most} {why}")).collect();
        let bounds = bounds.into_iter().collect::<Vec<_>>().join(", ");
        return vec![format!(
            "{} loops, each with one of these bounds: {bounds}",
            found.loops.len()
        )];
    }
    let told = found.loops.iter().map(|(owner, most, why)| {
        let place = if owner.contains("::") {
            format!("loop in `{}`", short(owner))
        } else {
            owner.clone()
        };
        format!("{place}: {most} {why}")
    });
    told.collect()
}

/// The last two names of a path.
fn short(path: &str) -> String {
    let names: Vec<_> = path.split("::").collect();
    names.get(names.len().saturating_sub(2)..).unwrap_or(&names).join("::")
}

/// The document with the table between its markers.
///
/// # Errors
/// Where it has no markers.
pub fn replace(document: &str, table: &str) -> Result<String> {
    let (before, _, after) = parts(document)?;
    Ok(format!("{before}{BEGIN}\n{table}{END}{after}"))
}

/// The document's table beside this one.
///
/// # Errors
/// Where it has no markers.
pub fn compare(document: &str, table: &str) -> Result<Comparison> {
    let (_, old, _) = parts(document)?;
    let old = old.trim_start_matches('\n');
    let compiled = |text: &str| {
        let line = text.lines().find(|line| line.starts_with(COMPILED)).unwrap_or("nothing");
        line.trim_start_matches(COMPILED).trim_end_matches('.').to_owned()
    };
    let (document, here) = (compiled(old), compiled(table));
    if old == table {
        Ok(Comparison::Same)
    } else if document != here && document != "nothing" {
        Ok(Comparison::OtherCompiler { document, here })
    } else {
        let difference = TextDiff::from_lines(old, table);
        Ok(Comparison::Different(difference.unified_diff().context_radius(0).to_string()))
    }
}

fn parts(document: &str) -> Result<(&str, &str, &str)> {
    let (before, rest) = document.split_once(BEGIN).with_context(|| format!("no {BEGIN}"))?;
    let (table, after) = rest.split_once(END).with_context(|| format!("no {END}"))?;
    Ok((before, table, after))
}

#[cfg(test)]
mod tests {
    use super::{Comparison, compare, replace};

    const DOCUMENT: &str = "a\n<!-- audit:begin -->\n<!-- audit:end -->\nz\n";
    const TABLE: &str = "Compiled by rustc 1.\n\n| a | 5 |\n";

    #[test]
    fn what_was_written_is_the_same() {
        let written = replace(DOCUMENT, TABLE).expect("markers");
        assert!(written.starts_with("a\n") && written.ends_with("\nz\n"), "{written}");
        assert_eq!(compare(&written, TABLE).expect("markers"), Comparison::Same);
        assert_eq!(replace(&written, TABLE).expect("markers"), written);
    }

    #[test]
    fn another_figure_is_a_difference_and_another_compiler_is_none() {
        let written = replace(DOCUMENT, TABLE).expect("markers");
        let other = TABLE.replace("| 5 |", "| 6 |");
        let found = compare(&written, &other).expect("markers");
        assert!(matches!(found, Comparison::Different(text) if text.contains("+| a | 6 |")));
        let newer = other.replace("rustc 1", "rustc 2");
        let found = compare(&written, &newer).expect("markers");
        assert!(matches!(found, Comparison::OtherCompiler { .. }));
    }

    #[test]
    fn a_document_without_a_table_is_no_match() {
        let found = compare(DOCUMENT, TABLE).expect("markers");
        assert!(matches!(found, Comparison::Different(_)));
        assert!(compare("nothing here", TABLE).is_err());
    }
}
