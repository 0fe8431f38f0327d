//! Which items of the source promise constant time, and which rows show it.
//!
//! An item promises where the `# Timing` section of its documentation has the
//! word *constant* in its first sentence, or says that it takes what another
//! item takes, which promises.

mod promises;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};

use self::promises::Collector;
use crate::rows::Rows;

/// A `# Timing` section.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Promise {
    /// The item: crate, modules, type, function.
    pub item: String,
    /// Where it stands.
    pub file: PathBuf,
    /// On which line.
    pub line: usize,
    /// Its first sentence.
    pub says: String,
}

/// A row and the source that do not agree.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub enum Disagreement {
    /// An item that promises, and that no row is about.
    NoRow {
        /// The item.
        item: String,
        /// Where its promise stands.
        place: String,
    },
    /// A row about an item that there is not, or that promises nothing.
    NoPromise {
        /// The row.
        row: String,
        /// The item.
        item: String,
    },
}

impl fmt::Display for Disagreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRow { item, place } => {
                write!(f, "{item} promises constant time, and no row shows it ({place})")
            }
            Self::NoPromise { row, item } => {
                write!(f, "row {row:?} names {item}, which does not promise constant time")
            }
        }
    }
}

/// All items in the folders that promise constant time. A folder is a crate's
/// `src`, beside its `Cargo.toml`.
///
/// # Errors
/// Where a file cannot be read, or has a `# Timing` section that belongs to no
/// item that the audit sees.
pub fn promises(folders: &[PathBuf]) -> Result<Vec<Promise>> {
    let mut sections = Vec::new();
    for folder in folders {
        let root = crate_name(folder)?;
        for file in files(folder)? {
            sections.extend(in_file(folder, &root, &file)?);
        }
    }
    ensure!(!sections.is_empty(), "no item has a `# Timing` section");
    Ok(promising(sections))
}

/// Where rows and promises disagree.
pub fn compare(rows: &Rows, promises: &[Promise]) -> Vec<Disagreement> {
    let promised: BTreeSet<_> = promises.iter().map(|promise| &*promise.item).collect();
    let named: BTreeSet<_> =
        rows.rows.iter().flat_map(|row| &row.items).map(String::as_str).collect();
    let missing = promises.iter().filter(|promise| !named.contains(&*promise.item));
    let no_row = missing.map(|promise| Disagreement::NoRow {
        item: promise.item.clone(),
        place: format!("{}:{}", promise.file.display(), promise.line),
    });
    let no_promise = rows.rows.iter().flat_map(|row| {
        let idle = row.items.iter().filter(|item| !promised.contains(&***item));
        idle.map(|item| Disagreement::NoPromise { row: row.name.clone(), item: item.clone() })
    });
    no_row.chain(no_promise).collect::<BTreeSet<_>>().into_iter().collect()
}

fn crate_name(folder: &Path) -> Result<String> {
    let manifest = folder.parent().unwrap_or(Path::new(".")).join("Cargo.toml");
    let text = std::fs::read_to_string(&manifest)
        .with_context(|| format!("{} cannot be read", manifest.display()))?;
    let manifest: toml::Table = toml::from_str(&text)?;
    let name = manifest.get("package").and_then(|package| package.get("name")?.as_str());
    Ok(name.context("a crate without a name")?.replace('-', "_"))
}

fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(&folder)
            .with_context(|| format!("{} cannot be read", folder.display()))?;
        for entry in entries {
            let path = entry?.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

fn in_file(folder: &Path, root: &str, file: &Path) -> Result<Vec<Promise>> {
    let text = std::fs::read_to_string(file)?;
    let parsed =
        syn::parse_file(&text).with_context(|| format!("{} is no Rust", file.display()))?;
    let sections = Collector::collect(&parsed, module_of(folder, root, file), file);
    // What stands in a macro that the audit cannot read would be lost.
    let written = text.lines().filter(|line| is_heading(line)).count();
    ensure!(
        sections.len() == written,
        "{} has {written} `# Timing` sections, of which {} belong to items that the audit sees",
        file.display(),
        sections.len()
    );
    Ok(sections)
}

fn is_heading(line: &str) -> bool {
    let line = line.trim_start();
    ["///", "//!"]
        .iter()
        .any(|mark| line.strip_prefix(mark).is_some_and(|it| it.trim() == "# Timing"))
}

fn module_of(folder: &Path, root: &str, file: &Path) -> Vec<String> {
    let inside = file.strip_prefix(folder).unwrap_or(file).with_extension("");
    let parts = inside.iter().map(|part| part.to_string_lossy().into_owned());
    let mut module: Vec<_> = std::iter::once(root.to_owned()).chain(parts).collect();
    module.pop_if(|last| ["lib", "mod", "main"].contains(&&**last));
    module
}

/// Those that promise by themselves, and those that point to one of them.
fn promising(sections: Vec<Promise>) -> Vec<Promise> {
    let mut promising = BTreeMap::<String, Promise>::new();
    loop {
        let known = promising.len();
        for section in &sections {
            let points = pointed_at(&section.says).is_some_and(|name| {
                promising.keys().any(|item| item.ends_with(&format!("::{name}")))
            });
            if points || says_constant(&section.says) {
                promising.insert(section.item.clone(), section.clone());
            }
        }
        if promising.len() == known {
            return promising.into_values().collect();
        }
    }
}

fn says_constant(says: &str) -> bool {
    let lower = says.to_lowercase();
    let words: Vec<_> = lower.split(|letter: char| !letter.is_alphabetic()).collect();
    words.iter().enumerate().any(|(at, word)| {
        *word == "constant" && at.checked_sub(1).is_none_or(|at| words.get(at) != Some(&"not"))
    })
}

/// ``As [`Type::function`]``.
fn pointed_at(says: &str) -> Option<&str> {
    let name = says.strip_prefix("As [`")?;
    name.split_once('`').map(|(name, _)| name)
}

#[cfg(test)]
mod tests;
