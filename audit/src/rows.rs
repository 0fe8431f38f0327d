//! What is audited: the rows of `rows.toml`.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use serde::Deserialize;

use crate::isa::Isa;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rows {
    /// In the order in which they are printed.
    #[serde(rename = "row", default)]
    pub rows: Vec<Row>,
    /// The bound of each exclusive access, in all rows.
    exclusive: Option<Exclusive>,
}

/// A read-modify-write of Thumb-2: it is a loop, which turns again where an
/// interrupt or another core came between its load and its store.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exclusive {
    /// The most turns.
    pub most: u64,
    /// What is counted.
    pub why: String,
}

/// One audited function, and what is allowed in it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// A symbol, or a path in the source.
    pub symbol: String,
    /// What it does.
    pub name: String,
    /// The heading that it stands under.
    #[serde(default)]
    pub group: String,
    /// The public items whose promise of constant time it shows.
    #[serde(default)]
    pub items: Vec<String>,
    /// Where it is audited.
    #[serde(default = "everywhere")]
    pub targets: Vec<Isa>,
    /// The loops that it may have.
    #[serde(default)]
    pub loops: Vec<Bound>,
    /// Where the walk stops, since the function has a row of its own.
    #[serde(default)]
    pub cold: Vec<String>,
    /// The system calls that it may make.
    #[serde(default)]
    pub system_calls: Vec<String>,
    /// The functions of other objects that it may call.
    #[serde(default)]
    pub external: Vec<External>,
    /// Why it may call what memory says.
    pub indirect: Option<String>,
    /// What else it may do, and why: `kind: reason`.
    #[serde(default)]
    pub may: Vec<String>,
    /// Another row's symbol: the longest paths of both must be equal.
    pub same_as: Option<String>,
    /// Where they must be: on all of the row's targets, or on these.
    pub same_on: Option<Vec<Isa>>,
    /// As [`Rows`] says.
    #[serde(skip)]
    pub exclusive: Option<Exclusive>,
    /// For the must-reject set alone: all kinds of things that the audit finds
    /// wrong with it. Such a row holds when they are found, and no others.
    #[serde(default)]
    pub rejected: Option<Vec<String>>,
    /// Whether some call executes just as many instructions as the bound says.
    #[serde(default)]
    pub reaches_bound: bool,
    /// Whether it is single-stepped.
    #[serde(default = "yes")]
    pub step: bool,
    /// Why it is not.
    pub step_why: Option<String>,
}

/// A loop that may be, and how often it turns.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// The function of the source that holds it: a part of its path.
    #[serde(rename = "in")]
    pub within: String,
    /// The most turns, each time that it is come to.
    pub most: u64,
    /// What is counted.
    pub why: String,
    /// How many loops of the same function it is nested in; any where it is not
    /// said.
    pub depth: Option<usize>,
}

/// A function of another object.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct External {
    /// Its name.
    pub symbol: String,
    /// Why it may be called.
    pub why: String,
}

fn everywhere() -> Vec<Isa> {
    vec![Isa::X86_64, Isa::Thumb]
}

fn yes() -> bool {
    true
}

impl Rows {
    /// Reads the file.
    ///
    /// # Errors
    /// Where it is no such file, or contradicts itself.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("{} cannot be read", path.display()))?;
        Self::parse(&text).with_context(|| format!("{} cannot be used", path.display()))
    }

    /// As [`Rows::read`], from what stands in the file.
    ///
    /// # Errors
    /// As there.
    pub fn parse(text: &str) -> Result<Self> {
        let mut rows: Self = toml::from_str(text)?;
        for row in &mut rows.rows {
            row.exclusive.clone_from(&rows.exclusive);
        }
        ensure!(!rows.rows.is_empty(), "it has no rows");
        let mut names = BTreeSet::new();
        for row in &rows.rows {
            let fresh = names.insert((&row.group, &row.name));
            ensure!(fresh, "two rows are called {:?} in {:?}", row.name, row.group);
            row.check(&rows).with_context(|| format!("row {:?}", row.name))?;
        }
        Ok(rows)
    }
}

impl Row {
    fn check(&self, rows: &Rows) -> Result<()> {
        for cold in &self.cold {
            let audited = rows.rows.iter().any(|row| row.symbol == *cold);
            ensure!(audited, "{cold} is cold, and no row of its own audits it");
        }
        if let Some(same) = &self.same_as {
            let audited = rows.rows.iter().any(|row| row.symbol == *same);
            ensure!(audited, "it has to be as {same}, which no row audits");
        }
        ensure!(self.step || self.step_why.is_some(), "step = false needs a step_why");
        ensure!(
            self.may.iter().all(|may| may.contains(": ")),
            "each `may` is a kind, a colon and a reason"
        );
        ensure!(self.loops.iter().all(|bound| bound.most > 0), "a loop that turns at most never");
        Ok(())
    }
}
