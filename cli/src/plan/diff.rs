//! `plan diff`: what changed, field by field.

use faregate_planner::file::{self, Change, Difference};
use serde::Serialize;

use crate::args::{Format, PlanDiffArgs};
use crate::exit::{Exit, Failure};
use crate::out;
use crate::plan::files;

/// What changed, for programs.
#[derive(Serialize)]
struct Found<'a> {
    same: bool,
    differences: &'a [Difference],
}

pub(crate) fn diff(args: &PlanDiffArgs) -> Result<Exit, Failure> {
    let bad = Exit::Never;
    let parameters = files::parameters(args.parameters.as_deref(), bad)?;
    let before = files::document(&args.before, parameters.as_ref(), bad)?;
    let after = files::document(&args.after, parameters.as_ref(), bad)?;
    let Some(differences) = file::differences(&before, &after, parameters.as_ref()) else {
        let (a, b) = (args.before.display(), args.after.display());
        let why = format!("{a} is {}, and {b} is {}", before.what(), after.what());
        return Err(Failure::Because(bad, why));
    };
    match args.format {
        Format::Json => {
            out::json(&Found { same: differences.is_empty(), differences: &differences })?;
        }
        Format::Text => differences.iter().try_for_each(|one| out::line(line(one)))?,
    }
    match differences.is_empty() {
        true => Ok(Exit::Done),
        false => Err(Failure::Said(Exit::Failed)),
    }
}

fn line(one: &Difference) -> String {
    let style = match one.change {
        Change::Added(_) => out::GOOD,
        Change::Removed(_) => out::BAD,
        Change::Set { .. } | Change::Moved => out::ODD,
    };
    out::styled(style, one)
}
