//! Words of the sub-commands about plans.

mod files;
mod make;
mod run;

use clap::Subcommand;

pub(crate) use files::{PlanCheckArgs, PlanConvertArgs, PlanDiffArgs, PlanNewArgs, TemplateName};
pub(crate) use make::{PlanMakeArgs, TableFormat};
pub(crate) use run::{PlanRunArgs, RunFormat};

/// What is to be done with a plan.
#[derive(Debug, Subcommand)]
pub(crate) enum PlanAction {
    /// Makes a timed plan: what runs when, and why the rest does not.
    Make(PlanMakeArgs),
    /// Executes a plan on a simulated rover, faster than real time, planning
    /// again as it goes.
    Run(PlanRunArgs),
    /// Reads plans, parameters and states, and reports everything that is wrong
    /// with them, each and together. Mistakes end with exit code 1, warnings
    /// alone with 0.
    Check(PlanCheckArgs),
    /// Writes a plan, parameters or a state in the other form: XML for people,
    /// or compact and with a checksum.
    Convert(PlanConvertArgs),
    /// Tells what changed between two plans, parameters or states, field by
    /// field.
    Diff(PlanDiffArgs),
    /// Writes a plan, parameters or a state to begin with.
    New(PlanNewArgs),
}
