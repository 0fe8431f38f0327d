//! `plan`: what the onboard planner has to do with.

mod check;
mod convert;
mod diff;
mod files;
mod input;
mod make;
mod mission;
mod new;
mod run;

use crate::args::PlanAction;
use crate::exit::{Exit, Failure};

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
