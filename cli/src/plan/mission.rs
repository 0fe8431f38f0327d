//! Whether parameters, plans and a mission agree.

use faregate_planner::tasks::{Disagreement, Library, Misfit, mission_fits, plan_fits};
use faregate_planner::{Parameters, Plan};
use faregate_scheduler::format::reading::{self, Report, Wrong};
use faregate_scheduler::format::{self, Diagnostic, Rule};

use crate::exit::Failure;
use crate::schedule::Source;
use crate::simulation;

/// Everything that the parameters or a plan and the mission in this file say
/// differently, and what is wrong with the file itself. Sequences of the plan are
/// the file's tasks.
pub(crate) fn fits<'p>(
    parameters: Option<&Parameters>,
    plans: impl Iterator<Item = &'p Plan>,
    file: &Source,
) -> Result<Vec<Diagnostic>, Failure> {
    let Some(parameters) = parameters else {
        let why = "--mission is compared with parameters: name their file, too";
        return Err(Failure::failed(why.to_owned()));
    };
    let loaded = match format::read(&file.name, &file.bytes) {
        Ok(loaded) => loaded,
        Err(found) => return Ok(found),
    };
    let Some(mut mission) = loaded.mission else {
        let why = format!("{} has no mission: give it a table [mission]", file.name);
        return Err(Failure::failed(why));
    };
    simulation::complete(&mut mission);
    let mut differ = mission_fits(parameters, &mission);
    for plan in plans {
        let library = Library::read(&file.name, &file.bytes);
        let library = library.map_err(|why| {
            Failure::failed(format!("{} has no sequences for {}: {why}", file.name, plan.name))
        })?;
        differ.extend(plan_fits(plan, &library, &mission));
    }
    Ok(told(&differ, file).unwrap_or_else(|found| found))
}

fn told(differ: &[Disagreement], file: &Source) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let source = reading::Source::new(&file.name, &file.bytes)?;
    let mut report = Report::new(&source);
    let at = source.text().find("[mission").unwrap_or(0);
    for one in differ {
        report.error(at..at, "mission", Wrong::new(rule(one), one.to_string()));
    }
    Ok(report.found)
}

const fn rule(differ: &Disagreement) -> Rule {
    match differ {
        Disagreement::NoCategory(_)
        | Disagreement::NoEngine(_)
        | Disagreement::NoHeater(_)
        | Disagreement::NoAgent
        | Disagreement::Activity(Misfit::Sequence(..) | Misfit::Gate(..)) => Rule::UnknownName,
        Disagreement::Names { .. } => Rule::Duplicate,
        _ => Rule::Limits,
    }
}
