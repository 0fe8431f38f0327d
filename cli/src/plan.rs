//! `plan`: what the onboard planner has to do with.

mod check;
mod convert;
mod diff;
mod files;
pub(crate) mod input;
mod make;
pub(crate) mod mission;
mod new;
mod run;
mod whys;

use faregate_planner::problem::Unfit;

use crate::args::PlanAction;
use crate::exit::{Exit, Failure};

pub(crate) use whys::why;

/// Why there is nothing to plan with these files.
pub(crate) fn unfit_for(unfit: &[Unfit]) -> Failure {
    let all: Vec<String> = unfit.iter().map(ToString::to_string).collect();
    Failure::failed(format!("nothing can be planned: {}", all.join("; ")))
}

pub(crate) fn plan(action: &PlanAction) -> Result<Exit, Failure> {
    match action {
        PlanAction::Make(args) => make::make(args),
        PlanAction::Run(args) => run::run(args),
        PlanAction::Check(args) => check::check(args),
        PlanAction::Convert(args) => convert::convert(args),
        PlanAction::Diff(args) => diff::diff(args),
        PlanAction::New(args) => new::new(args),
    }
}
