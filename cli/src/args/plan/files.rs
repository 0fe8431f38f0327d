//! Words of the sub-commands about files of the planner.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::args::Format;

#[derive(Debug, Args)]
#[command(after_help = "\
Parameters among the files are what the others are judged by, and a plan and a
state are judged together, too. With a mission, the parameters are compared with
what it has (supply, categories, engines, heaters), and plans with what its tasks
command: two activities with one gate need a resource in common.

Examples:
  faregate plan check sol.xml parameters.xml state.xml
  faregate plan check sol.xml parameters.xml --mission rover.toml")]
pub(crate) struct PlanCheckArgs {
    /// Plans, parameters and states, as XML or in the compact form.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// The mission on which timed plans are to be executed, in a schedule's
    /// native format.
    #[arg(long, value_name = "FILE")]
    pub(crate) mission: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

#[derive(Debug, Args)]
#[command(after_help = "\
With parameters, times of day are read and written by their day, and resources
have their names. Without, times are written in seconds and resources as bits.
Comments of the XML are not kept.

Examples:
  faregate plan convert sol.xml sol.bin -p parameters.xml
  faregate plan convert sol.bin again.xml -p parameters.xml")]
pub(crate) struct PlanConvertArgs {
    /// The file, in either form.
    #[arg(value_name = "IN")]
    pub(crate) from: PathBuf,
    /// The file to be written: .xml, or .bin for the compact form.
    #[arg(value_name = "OUT")]
    pub(crate) to: PathBuf,
    /// What only the ground changes: days and names are known by it.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Exit codes:
  0  they say the same
  1  they differ
  5  one of them has mistakes, or they are not of the same kind

Example:
  faregate plan diff yesterday.bin today.xml -p parameters.xml")]
pub(crate) struct PlanDiffArgs {
    /// The one before, in either form.
    #[arg(value_name = "A")]
    pub(crate) before: PathBuf,
    /// The one after, in either form.
    #[arg(value_name = "B")]
    pub(crate) after: PathBuf,
    /// What only the ground changes: days and names are known by it.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  for one in plan parameters state; do
      faregate plan new --template $one --out $one.xml
  done
  faregate plan check plan.xml parameters.xml state.xml")]
pub(crate) struct PlanNewArgs {
    /// What to begin with.
    #[arg(long, value_enum)]
    pub(crate) template: TemplateName,
    /// The file to be written, which must not be there. Without it: standard
    /// output.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// What there is to begin with: the three go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TemplateName {
    /// A small sol with one activity of each type.
    Plan,
    /// What only the ground changes: limits, powers, preheat tables.
    Parameters,
    /// What is so on the morning of that sol.
    State,
}
