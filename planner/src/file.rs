//! Plans, parameters and states in files: XML that people write, and a compact
//! binary form for the link and on board. Either is lossless, and from either
//! the same is read.
//!
//! A file is loaded whole or not at all, and everything that is wrong with it
//! is told at once, with its line and column. Comments are for people: they are
//! not in the model, and so not in what is written from it.
//!
//! ```
//! use faregate_planner::file;
//!
//! let text = r#"<plan version="1" name="sol 7" handover="20:00" handover_min_soc="50 %"
//!     end="1T10:00" max_delta_data="100 MB">
//!   <activity id="1" priority="200" duration="25 min" marginal="40">
//!     <start from="10:00" to="09:00" cutoff="12:00"/>
//!   </activity>
//! </plan>"#;
//! let wrong = file::read("sol7.xml", text.as_bytes(), None).unwrap_err();
//! let places: Vec<_> = wrong.iter().filter(|one| one.is_error())
//!     .map(|one| (one.place.line, one.place.column)).collect();
//! assert_eq!(places, [(3, 63), (4, 29)]);
//! ```
//!
//! `docs/plan-format.md` is the reference.

pub mod binary;
#[cfg(test)]
mod broken;
mod check;
mod difference;
mod fields;
#[cfg(test)]
mod generated;
mod load;
mod names;
mod read;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod round_trip;
mod schema;
mod show;
pub mod template;
mod times;
mod value;
mod words;
mod write;
mod xml;

pub use difference::{Change, Difference, differences};
use faregate_scheduler::format::Diagnostic;
use faregate_scheduler::format::reading::{Report, Source};

use crate::file::load::{ROOTS, only, read_as};
use crate::file::names::Names;
use crate::parameters::Parameters;
use crate::plan::Plan;
use crate::state::State;

/// The version of both forms. It changes with the models; a test has binary
/// files of this one.
pub const VERSION: u16 = 1;

/// What a file has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Document {
    /// A plan.
    Plan(Plan),
    /// Parameters.
    Parameters(Parameters),
    /// A state.
    State(State),
}

/// What was read, and what somebody should look at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loaded<T> {
    /// What was read.
    pub value: T,
    /// What somebody should look at.
    pub warnings: Vec<Diagnostic>,
}

/// Reads a file in either form.
///
/// Names of resources, zones and timelines, and the day by which times are
/// read, are those of the parameters. Without them, times are of Mars's days,
/// no zone or timeline is unknown, and a warning says so.
///
/// # Errors
///
/// Everything that is wrong with it, warnings among it. Nothing is loaded.
pub fn read(
    name: &str,
    bytes: &[u8],
    parameters: Option<&Parameters>,
) -> Result<Loaded<Document>, Vec<Diagnostic>> {
    read_as(name, bytes, parameters, ROOTS)
}

/// Reads a plan.
///
/// # Errors
///
/// Everything that is wrong with it, and that it is none.
pub fn plan(
    name: &str,
    bytes: &[u8],
    parameters: Option<&Parameters>,
) -> Result<Loaded<Plan>, Vec<Diagnostic>> {
    only(name, "a plan", read_as(name, bytes, parameters, "a plan")?, |document| match document {
        Document::Plan(plan) => Some(plan),
        _ => None,
    })
}

/// Reads parameters.
///
/// # Errors
///
/// Everything that is wrong with them, and that they are none.
pub fn parameters(name: &str, bytes: &[u8]) -> Result<Loaded<Parameters>, Vec<Diagnostic>> {
    only(name, "parameters", read_as(name, bytes, None, "parameters")?, |document| match document {
        Document::Parameters(parameters) => Some(parameters),
        _ => None,
    })
}

/// Reads a state.
///
/// # Errors
///
/// Everything that is wrong with it, and that it is none.
pub fn state(
    name: &str,
    bytes: &[u8],
    parameters: Option<&Parameters>,
) -> Result<Loaded<State>, Vec<Diagnostic>> {
    only(name, "a state", read_as(name, bytes, parameters, "a state")?, |document| match document {
        Document::State(state) => Some(state),
        _ => None,
    })
}

/// What is wrong with a plan together with the parameters and the state that it
/// is to be made with: told at the state, whose file this is.
#[must_use]
pub fn together(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    (name, bytes): (&str, &[u8]),
) -> Vec<Diagnostic> {
    let text = if binary::is_binary(bytes) { b"" } else { bytes };
    let Ok(source) = Source::new(name, text) else { return Vec::new() };
    let mut report = Report::new(&source);
    // What is wrong with the file itself was told when it was read.
    let root = xml::parse(source.text(), &mut Report::new(&source)).unwrap_or_default();
    check::together(plan, parameters, state, &root, &mut report);
    report.found
}

/// The document as XML: with names and times of day where there are
/// parameters, with bits and seconds where there are none. It is read again as
/// the same, with the same parameters.
#[must_use]
pub fn to_xml(document: &Document, parameters: Option<&Parameters>) -> String {
    write::text(&write::element(document, &Names::new(parameters)))
}

/// The document in the compact form.
#[must_use]
pub fn to_binary(document: &Document) -> Vec<u8> {
    match document {
        Document::Plan(plan) => binary::write(plan),
        Document::Parameters(parameters) => binary::write(parameters),
        Document::State(state) => binary::write(state),
    }
}

impl Document {
    /// What people call it.
    #[must_use]
    pub const fn what(&self) -> &'static str {
        match self {
            Self::Plan(_) => "a plan",
            Self::Parameters(_) => "parameters",
            Self::State(_) => "a state",
        }
    }
}
