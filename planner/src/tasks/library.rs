//! Sequences by name: what activities command.

use core::fmt;
use std::collections::BTreeMap;

use faregate_scheduler::format::{self, Diagnostic};
use faregate_scheduler::task::{Body, Step};

/// What each sequence does.
///
/// A schedule file in the native format: each of its tasks is a sequence, by
/// the task's name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Library(BTreeMap<String, Vec<Step>>);

/// Why a file is no library.
#[derive(Clone, Debug)]
pub enum NoLibrary {
    /// It cannot be read.
    Unread(Vec<Diagnostic>),
    /// The task of this number has no name.
    Nameless(u32),
    /// The task of this name is no sequence.
    NoSequence(String),
    /// Two sequences have this name.
    Twice(String),
}

impl Library {
    /// No sequences.
    #[must_use]
    pub const fn new() -> Self {
        Self(BTreeMap::new())
    }

    /// Reads a schedule file.
    ///
    /// # Errors
    /// [`NoLibrary`]: nothing is loaded.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, NoLibrary> {
        // Whether the mission has the gates is judged with the plan.
        let options = format::Options { against: format::Against::Nothing, ..Default::default() };
        let loaded = format::read_with(options, name, bytes).map_err(NoLibrary::Unread)?;
        let mut library = Self::new();
        for task in loaded.tasks {
            let name = task.name.ok_or(NoLibrary::Nameless(task.id.get()))?;
            let Body::Sequence(steps) = task.body else { return Err(NoLibrary::NoSequence(name)) };
            if library.0.insert(name.clone(), steps).is_some() {
                return Err(NoLibrary::Twice(name));
            }
        }
        Ok(library)
    }

    /// Adds a sequence, in place of one of the same name.
    pub fn add(&mut self, name: &str, steps: Vec<Step>) {
        self.0.insert(name.to_owned(), steps);
    }

    /// The steps of a sequence.
    #[must_use]
    pub fn steps(&self, name: &str) -> Option<&[Step]> {
        self.0.get(name).map(Vec::as_slice)
    }
}

/// The gates that steps command, each once.
pub(super) fn gates(steps: &[Step]) -> Vec<String> {
    let mut gates: Vec<_> = steps.iter().map(|step| step.gate.clone()).collect();
    gates.sort_unstable();
    gates.dedup();
    gates
}

impl fmt::Display for NoLibrary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unread(found) => {
                let errors = found.iter().filter(|one| one.is_error());
                let told = errors.map(|one| format!("line {}: {}", one.place.line, one.message));
                f.write_str(&told.collect::<Vec<_>>().join("; "))
            }
            Self::Nameless(id) => write!(f, "task {id} has no name: sequences are found by name"),
            Self::NoSequence(name) => write!(f, "`{name}` is no sequence: give it steps"),
            Self::Twice(name) => write!(f, "two sequences have the name `{name}`"),
        }
    }
}

impl core::error::Error for NoLibrary {}
