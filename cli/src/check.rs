//! `check`: everything that is wrong with schedules and missions.

use faregate_scheduler::format::Diagnostic;
use serde::Serialize;

use crate::args::{CheckArgs, Format};
use crate::exit::{Exit, Failure};
use crate::schedule::{self, Examined};
use crate::{out, report};

/// What was found, for programs.
#[derive(Serialize)]
struct Findings<'a> {
    errors: usize,
    warnings: usize,
    /// None was loaded where there are errors.
    tasks: Option<usize>,
    diagnostics: &'a [Diagnostic],
}

pub(crate) fn check(args: &CheckArgs) -> Result<Exit, Failure> {
    let Examined { schedule, diagnostics, sources } = schedule::examine(&args.files)?;
    let errors = diagnostics.iter().filter(|one| one.is_error()).count();
    let warnings = diagnostics.len() - errors;
    let tasks = schedule.map(|schedule| schedule.tasks.len());
    match args.format {
        Format::Json => {
            out::json(&Findings { errors, warnings, tasks, diagnostics: &diagnostics })?;
        }
        Format::Text => {
            report::complain(&diagnostics, &sources);
            out::line(verdict(errors, warnings, tasks))?;
        }
    }
    if errors == 0 { Ok(Exit::Done) } else { Err(Failure::Said(Exit::Failed)) }
}

fn verdict(errors: usize, warnings: usize, tasks: Option<usize>) -> String {
    let warned = match warnings {
        0 => String::new(),
        _ => format!(", {}", number(warnings, "warning")),
    };
    match tasks {
        Some(tasks) => {
            out::styled(out::GOOD, "good") + &format!(": {}{warned}", number(tasks, "task"))
        }
        None => {
            out::styled(out::BAD, number(errors, "error")) + &format!("{warned}; nothing is loaded")
        }
    }
}

fn number(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
