//! Schedule files: SMAARTE's, with spaces or with commas, and the native one,
//! which has every field of tasks and mission.
//!
//! A file is loaded whole or not at all, and everything that is wrong with it
//! is told at once, with its line and column.
//!
//! ```
//! use faregate_scheduler::format;
//!
//! let text = "id,st,et,dur,con,pri,type,interval,args\n\
//!             11,0,0,3,1,1,0,0,sleep 3\n\
//!             12,0,0,x,1,240,0,0,sleep 3\n";
//! let wrong = format::read("demo.csv", text.as_bytes()).unwrap_err();
//! let places: Vec<_> = wrong.iter().map(|one| (one.place.line, one.place.column)).collect();
//! assert_eq!(places, [(3, 8), (3, 12)]);
//! ```
//!
//! `docs/schedule-format.md` is the reference.

mod body;
mod check;
mod columns;
mod diagnostic;
mod draft;
mod native;
mod policy;
mod render;
mod rows;
pub mod say;
mod scalar;
mod smaarte;
mod source;
mod suggest;
mod words;
mod write;
mod wrong;

use std::collections::BTreeMap;
use std::path::Path;

pub use check::together;
pub use diagnostic::{Also, Diagnostic, Place, Rule, Severity};
pub use render::render;
pub use scalar::Conflict;
pub use write::{NotHeld, write};

use crate::format::check::Judge;
use crate::format::draft::Draft;
use crate::format::native::Native;
use crate::format::source::Source;
use crate::format::wrong::{Report, Wrong};
use crate::mission::Mission;
use crate::task::{Task, TaskId};

/// For readers of other files, which tell what is wrong in the same way.
pub mod reading {
    pub use super::source::Source;
    pub use super::suggest::nearest;
    pub use super::wrong::{Report, Wrong, shown};
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// SMAARTE's, fields separated by spaces.
    Txt,
    /// SMAARTE's, fields separated by commas, with a header.
    Csv,
    /// Ours.
    Toml,
}

impl Kind {
    /// The format of a file by how its name ends.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        match Path::new(name).extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "txt" => Some(Self::Txt),
            "csv" => Some(Self::Csv),
            "toml" => Some(Self::Toml),
            _ => None,
        }
    }
}

/// How a file is read.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// The format; none: by how the name ends.
    pub kind: Option<Kind>,
    /// How SMAARTE's conflict column is read.
    pub conflict: Conflict,
    /// What the schedule is judged against.
    pub against: Against<'a>,
    /// Whether the file is the whole schedule, so that tasks that it refers to
    /// must be in it.
    pub whole: bool,
}

/// What a schedule is judged against.
#[derive(Clone, Copy, Debug)]
pub enum Against<'a> {
    /// The mission in the file, or the default one, which has nothing.
    Own,
    /// This mission; a file that has one of its own is refused.
    Mission(&'a Mission),
    /// Nothing: the file is only converted.
    Nothing,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self { kind: None, conflict: Conflict::Mask, against: Against::Own, whole: true }
    }
}

/// What a file has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loaded {
    /// The tasks, in the order of the file.
    pub tasks: Vec<Task>,
    /// The mission; none: the file has none.
    pub mission: Option<Mission>,
    /// What somebody should look at.
    pub warnings: Vec<Diagnostic>,
    /// Where each task stands.
    pub places: BTreeMap<TaskId, Place>,
}

/// Reads a schedule file; the name says in which format it is.
///
/// # Errors
///
/// Everything that is wrong with it, warnings among it. Nothing is loaded.
pub fn read(name: &str, bytes: &[u8]) -> Result<Loaded, Vec<Diagnostic>> {
    read_with(Options::default(), name, bytes)
}

/// Reads a schedule file.
///
/// # Errors
///
/// Everything that is wrong with it, warnings among it. Nothing is loaded.
pub fn read_with(
    options: Options<'_>,
    name: &str,
    bytes: &[u8],
) -> Result<Loaded, Vec<Diagnostic>> {
    let given = match options.against {
        Against::Mission(mission) => Some(mission),
        Against::Own | Against::Nothing => None,
    };
    read_named(options, name, bytes, given)
}

/// Reads a file in which categories may be called as this mission calls them.
fn read_named(
    options: Options<'_>,
    name: &str,
    bytes: &[u8],
    names: Option<&Mission>,
) -> Result<Loaded, Vec<Diagnostic>> {
    let source = Source::new(name, bytes)?;
    let mut report = Report::new(&source);
    let Some(kind) = options.kind.or_else(|| Kind::of(name)) else {
        let wrong = Wrong::new(Rule::Format, "the name does not say in which format this is");
        report.error(0..0, "", wrong.expected("a name that ends in .txt, .csv or .toml"));
        return Err(report.found);
    };
    let native = match kind {
        Kind::Txt => Native::of_tasks(smaarte::txt(&mut report, options.conflict)),
        Kind::Csv => Native::of_tasks(smaarte::csv(&mut report, options.conflict)),
        Kind::Toml => native::read(&mut report, names),
    };
    if matches!(options.against, Against::Mission(_)) && native.mission.is_some() {
        let wrong = Wrong::new(Rule::Duplicate, "the file has a mission, and another one is given");
        report.error(native.mission_at.clone(), "mission", wrong.expected("one mission"));
    }
    if report.is_hopeless() {
        return Err(hopeless(report));
    }
    judge(&native, options, &mut report);
    finish(native, report)
}

/// What was found until it was too much. Tasks were not read, so nothing is said
/// of who is missing.
fn hopeless(report: Report<'_>) -> Vec<Diagnostic> {
    let mut found = report.found;
    found.sort_by_key(in_order);
    if let Some(last) = found.last_mut() {
        let why = "so much is wrong that the file was read no further";
        last.help.get_or_insert_with(|| why.to_owned());
    }
    found
}

fn in_order(wrong: &Diagnostic) -> (usize, bool) {
    (wrong.place.span.start, wrong.is_error())
}

fn judge(native: &Native, options: Options<'_>, report: &mut Report<'_>) {
    let default = Mission::default();
    let mission = match options.against {
        Against::Own => Some(native.mission.as_ref().unwrap_or(&default)),
        Against::Mission(mission) => Some(mission),
        Against::Nothing => None,
    };
    let judge = Judge { mission, mission_good: native.mission_good, whole: options.whole };
    check::schedule(&native.drafts, judge, report);
}

fn finish(native: Native, report: Report<'_>) -> Result<Loaded, Vec<Diagnostic>> {
    let mut found = report.found;
    found.sort_by_key(in_order);
    if found.iter().any(Diagnostic::is_error) {
        return Err(found);
    }
    let place = |draft: &Draft| Some((draft.id?, report.source.place(draft.whole.clone())));
    let places = native.drafts.iter().filter_map(place).collect();
    let tasks = native.drafts.into_iter().filter_map(Draft::into_task).collect();
    Ok(Loaded { tasks, mission: native.mission, warnings: found, places })
}
