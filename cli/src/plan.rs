//! `plan`: what the onboard planner has to do with.

mod input;
mod make;

use crate::args::PlanAction;
use crate::exit::{Exit, Failure};

pub(crate) fn plan(action: &PlanAction) -> Result<Exit, Failure> {
    match action {
        PlanAction::Make(args) => make::make(args),
    }
}
