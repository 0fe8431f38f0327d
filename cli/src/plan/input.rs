//! A plan, its parameters and a state, read from files.

use std::path::Path;

use faregate_planner::file::{self, Loaded};
use faregate_planner::{Parameters, Plan, State};
use faregate_scheduler::format::Diagnostic;

use crate::exit::{Exit, Failure};
use crate::report;
use crate::schedule::Source;

/// What a timed plan is made from.
#[derive(Debug)]
pub(crate) struct Inputs {
    pub(crate) plan: Plan,
    pub(crate) parameters: Parameters,
    pub(crate) state: State,
}

/// Reads the three files. Everything that is wrong is told; where the
/// parameters cannot be read, the others are not judged, since their names
/// would mean nothing.
pub(crate) fn read(plan: &Path, parameters: &Path, state: &Path) -> Result<Inputs, Failure> {
    let (parameters_source, plan_source, state_source) =
        (Source::open(parameters)?, Source::open(plan)?, Source::open(state)?);
    let parameters = told(&parameters_source, |name, bytes| file::parameters(name, bytes))
        .ok_or(Failure::Said(Exit::Failed))?;
    let plan = told(&plan_source, |name, bytes| file::plan(name, bytes, Some(&parameters)));
    let state = told(&state_source, |name, bytes| file::state(name, bytes, Some(&parameters)));
    match (plan, state) {
        (Some(plan), Some(state)) => Ok(Inputs { plan, parameters, state }),
        _ => Err(Failure::Said(Exit::Failed)),
    }
}

/// What was read, if it could be; the rest is on standard error.
fn told<T>(
    source: &Source,
    read: impl FnOnce(&str, &[u8]) -> Result<Loaded<T>, Vec<Diagnostic>>,
) -> Option<T> {
    let (value, diagnostics) = match read(&source.name, &source.bytes) {
        Ok(loaded) => (Some(loaded.value), loaded.warnings),
        Err(wrong) => (None, wrong),
    };
    report::complain(&diagnostics, std::slice::from_ref(source));
    value
}
