//! Words of `plan make`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

#[derive(Debug, Args)]
#[command(after_help = MAKE_HELP)]
pub(crate) struct PlanMakeArgs {
    /// The plan: .xml, or its binary form.
    #[arg(value_name = "PLAN")]
    pub(crate) plan: PathBuf,
    /// What only the ground changes: limits, powers, preheat tables.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) parameters: PathBuf,
    /// What is so now: charge, mode, communication windows, what has run.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) state: PathBuf,
    /// How the result is printed: a table, or a document.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: TableFormat,
    /// Draws the timed plan into this file.
    #[arg(long, value_name = "OUT.svg")]
    pub(crate) svg: Option<PathBuf>,
    /// Looks for a better plan, by at most so many evaluations of candidates,
    /// those of the one pass included. An interrupt ends the search early; what
    /// was found by then counts.
    #[arg(long, value_name = "EVALUATIONS")]
    pub(crate) improve: Option<u64>,
    /// What the search is drawn from.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "improve")]
    pub(crate) seed: u64,
    /// The timed plan that is executed now: what starts within the commit
    /// window stays as it is.
    #[arg(long, value_name = "TIMED.json")]
    pub(crate) incumbent: Option<PathBuf>,
    /// Writes the timed plan itself: for --incumbent, and for `plan run`.
    #[arg(long, value_name = "TIMED.json")]
    pub(crate) out: Option<PathBuf>,
    /// Says of each activity that is left out the smallest change of each limit
    /// that would let it in at its turn.
    #[arg(long)]
    pub(crate) explain: bool,
}

const MAKE_HELP: &str = "\
Exit codes:
  0  every mandatory activity is scheduled
  1  a file cannot be read, or has mistakes, or the plan breaks a rule
  2  some mandatory activities are left out (or wrong usage)

Nothing is missed where a cleanup waits for a failure, or where another member
of a single selection group was selected.

Example:
  faregate plan make sol.xml -p parameters.xml -s state.xml --svg sol.svg";

/// How a timed plan is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    /// For people.
    #[default]
    Table,
    /// For programs.
    Json,
}
