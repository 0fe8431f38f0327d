//! A plan, its parameters and a state, read from files.

use std::path::Path;

use faregate_planner::file::{self, Loaded};
use faregate_planner::{Parameters, Plan, State};
use faregate_scheduler::format::Diagnostic;

use crate::exit::{Exit, Failure};
use crate::plan::files;
use crate::report;
use crate::schedule::Source;

/// What a timed plan is made from.
#[derive(Debug)]
pub(crate) struct Inputs {
    pub(crate) plan: Plan,
    pub(crate) parameters: Parameters,
    pub(crate) state: State,
}

/// Reads the three files. Everything that is wrong is told, what they do not
/// agree on included; where the parameters cannot be read, the others are not
/// judged, since their names would mean nothing.
pub(crate) fn read(plan: &Path, parameters: &Path, state: &Path) -> Result<Inputs, Failure> {
    let parameters = files::read(parameters, Exit::Failed, file::parameters)?;
    let (plan_source, state_source) = (Source::open(plan)?, Source::open(state)?);
    let plan = told(&plan_source, |name, bytes| file::plan(name, bytes, Some(&parameters)));
    let state = told(&state_source, |name, bytes| file::state(name, bytes, Some(&parameters)));
    let (Some(plan), Some(state)) = (plan, state) else { return Err(Failure::Said(Exit::Failed)) };
    let of_state = (state_source.name.as_str(), state_source.bytes.as_slice());
    let found = file::together(&plan, &parameters, &state, of_state);
    report::complain(&found, &[files::shown(state_source)]);
    if found.iter().any(Diagnostic::is_error) {
        return Err(Failure::Said(Exit::Failed));
    }
    Ok(Inputs { plan, parameters, state })
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
    report::complain(&diagnostics, &[files::shown(source.clone())]);
    value
}
