//! All rows, audited on all objects.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, ensure};

use crate::image::Image;
use crate::isa::Isa;
use crate::rows::{Row, Rows};
use crate::walk::{Outcome, audit};

/// What was found for a row.
#[derive(Debug, serde::Serialize)]
pub struct Finding {
    /// The heading that it stands under.
    pub group: String,
    /// What it does.
    pub name: String,
    /// The function.
    pub symbol: String,
    /// For each instruction set that the row names and an object was given for.
    pub outcomes: BTreeMap<Isa, Outcome>,
    /// What contradicts the row beside its violations: bounds and excuses that
    /// nothing needed, and longest paths that are not equal to another row's.
    pub idle: Vec<String>,
    /// What should be wrong with it.
    pub rejected: BTreeSet<String>,
}

/// Audits the rows on the objects.
///
/// # Errors
/// Where an object cannot be read, or no row is about any of them.
pub fn find(rows: &Rows, images: &BTreeMap<Isa, Image>) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for row in &rows.rows {
        let mut outcomes = BTreeMap::new();
        for isa in &row.targets {
            if let Some(image) = images.get(isa) {
                outcomes.insert(*isa, audit(image, row)?);
            }
        }
        if outcomes.is_empty() {
            continue;
        }
        // A bound for the other instruction set alone is no idle one.
        let all = row.targets.iter().all(|isa| outcomes.contains_key(isa));
        let rejected: BTreeSet<_> = row.rejected.iter().flatten().cloned().collect();
        let idle = if all && rejected.is_empty() { idle(row, &outcomes) } else { Vec::new() };
        let (group, name) = (row.group.clone(), row.name.clone());
        let symbol = row.symbol.clone();
        findings.push(Finding { group, name, symbol, outcomes, idle, rejected });
    }
    for row in rows.rows.iter().filter(|row| row.same_as.is_some()) {
        let apart = apart(row, &findings);
        let own = findings.iter_mut().find(|finding| finding.is_of(row));
        own.into_iter().for_each(|finding| finding.idle.extend(apart.clone()));
    }
    ensure!(!findings.is_empty(), "no row is about any of these objects");
    Ok(findings)
}

/// Where the row's longest path is not the one that it names.
fn apart(row: &Row, findings: &[Finding]) -> Vec<String> {
    let own = findings.iter().find(|finding| finding.is_of(row));
    let other = findings.iter().find(|finding| row.same_as.as_ref() == Some(&finding.symbol));
    let (Some(own), Some(other)) = (own, other) else { return Vec::new() };
    let differ = own.outcomes.iter().filter_map(|(isa, here)| {
        let there = other.outcomes.get(isa)?;
        row.same_on.as_ref().is_none_or(|on| on.contains(isa)).then_some(())?;
        let same = (here.instructions, here.locked) == (there.instructions, there.locked);
        let (title, name) = (isa.title(), &other.name);
        (!same).then(|| {
            format!(
                "{title}: {} instructions, not {} as {name:?}",
                here.instructions, there.instructions
            )
        })
    });
    differ.collect()
}

/// What the row allows and no object has: it would hide what comes later.
fn idle(row: &Row, outcomes: &BTreeMap<Isa, Outcome>) -> Vec<String> {
    let used: BTreeSet<_> = outcomes.values().flat_map(|found| &found.bounds_used).collect();
    let any = |has: &dyn Fn(&Outcome) -> bool| outcomes.values().any(has);
    let bounds = row.loops.iter().enumerate().filter(|(at, _)| !used.contains(at));
    let mut idle: Vec<_> =
        bounds.map(|(_, bound)| format!("no loop is in {}", bound.within)).collect();
    let kinds = row.may.iter().filter(|may| !any(&|found| found.excused.contains(*may)));
    idle.extend(kinds.map(|may| format!("nothing needs {may:?}")));
    let cold = row.cold.iter().filter(|cold| !any(&|found| found.cold.contains(*cold)));
    idle.extend(cold.map(|cold| format!("nothing calls the cold {cold}")));
    let calls =
        row.system_calls.iter().filter(|name| !any(&|found| found.system_calls.contains(*name)));
    idle.extend(calls.map(|name| format!("nothing makes the system call {name}")));
    let outside =
        row.external.iter().filter(|it| !any(&|found| found.external.contains(&it.symbol)));
    idle.extend(outside.map(|it| format!("nothing calls {}", it.symbol)));
    if row.indirect.is_some() && !any(&|found| found.port.is_some()) {
        idle.push("nothing calls through memory".to_owned());
    }
    idle
}

impl Finding {
    fn is_of(&self, row: &Row) -> bool {
        (&self.group, &self.name) == (&row.group, &row.name)
    }

    /// Whether all is as the row says.
    pub fn holds(&self) -> bool {
        self.idle.is_empty() && self.outcomes.values().all(|found| found.kinds() == self.rejected)
    }
}
