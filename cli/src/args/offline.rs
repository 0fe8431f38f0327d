//! Words of the sub-commands that need no running manager.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Format;

/// Which schedule, on which mission.
#[derive(Debug, Args)]
pub(crate) struct FilesArgs {
    /// Schedules: .csv and .txt as SMAARTE has them, or .toml.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// The mission, where the schedule does not bring it: agents, devices, modes.
    #[arg(long, short, value_name = "FILE.toml")]
    pub(crate) mission: Option<PathBuf>,
    /// How the conflict column is read.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) conflict: ConflictColumn,
}

/// How the conflict column of .csv and .txt files is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ConflictColumn {
    /// Each bit is a category (Gillette 2019).
    #[default]
    Mask,
    /// The number of one category (Gillette 2018).
    Number,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    pub(crate) files: FilesArgs,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

#[derive(Debug, Args)]
pub(crate) struct AnalyzeArgs {
    #[command(flatten)]
    pub(crate) files: FilesArgs,
    /// Draws the runs into this file.
    #[arg(long, value_name = "OUT.svg")]
    pub(crate) gantt: Option<PathBuf>,
    /// How far to look ahead, in seconds. Without it: to the end of the last
    /// task that runs once, or for a day where there are routine tasks.
    #[arg(long, value_name = "SECONDS", value_parser = crate::times::seconds)]
    pub(crate) horizon: Option<faregate_scheduler::time::Duration>,
    /// When the schedule is loaded: RFC 3339, or Unix seconds. Without it: now.
    #[arg(long, value_name = "TIME", value_parser = crate::times::time)]
    pub(crate) at: Option<faregate_scheduler::time::UnixTime>,
    /// One task at a time, as where nothing is known of what conflicts.
    #[arg(long)]
    pub(crate) serial: bool,
    /// So many runs with durations drawn at random, where tasks state a spread.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) samples: Option<u32>,
    /// What the durations are drawn from.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub(crate) seed: u64,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// The schedule.
    #[arg(value_name = "IN")]
    pub(crate) from: PathBuf,
    /// The file to be written; its ending is the format: .csv, .txt or .toml.
    #[arg(value_name = "OUT")]
    pub(crate) to: PathBuf,
    /// The mission, where the schedule does not bring it.
    #[arg(long, short, value_name = "FILE.toml")]
    pub(crate) mission: Option<PathBuf>,
    /// How the conflict column is read.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) conflict: ConflictColumn,
    /// Writes the file even if it cannot hold everything.
    #[arg(long)]
    pub(crate) lossy: bool,
    /// How the list is printed.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

#[derive(Debug, Args)]
#[command(after_help = RUN_HELP)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) files: FilesArgs,
    #[command(flatten)]
    pub(crate) planned: PlannedArgs,
    /// Where the journal is kept. With one, the schedule goes on where an
    /// earlier run ended, however that was; without, nothing outlives it.
    #[arg(long, value_name = "DIR")]
    pub(crate) journal: Option<PathBuf>,
    /// Takes telecommands at this socket, and does not end by itself.
    #[arg(long, value_name = "PATH")]
    pub(crate) socket: Option<PathBuf>,
    /// Ends after so many seconds. Without it: when the schedule is over, which
    /// one with routine tasks never is.
    #[arg(long = "for", value_name = "SECONDS", value_parser = crate::times::seconds)]
    pub(crate) time: Option<faregate_scheduler::time::Duration>,
    /// Runs so many times faster, on a virtual clock: nothing is executed, and
    /// every task takes the duration that it states.
    #[arg(long, value_name = "X", value_parser = crate::times::speed)]
    pub(crate) speed: Option<f64>,
    /// The same as fast as can be.
    #[arg(long = "virtual", conflicts_with = "speed")]
    pub(crate) virtual_clock: bool,
    /// What the simulated devices' chances are drawn from.
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub(crate) seed: u64,
    /// How changes are printed: lines, or a JSON document on each.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

const RUN_HELP: &str = "\
With --plan, FILE is the mission alone: each of its tasks is a sequence that
activities name, and none is run by itself. The onboard planner makes a timed
plan of the state, whose present instant is the run's begin; its activities,
awake time, heating and communication windows become tasks, and it plans again
when the world differs.

Examples:
  faregate run schedule.toml --journal kept --socket faregate.sock
  faregate run rover.toml --plan sol.xml -p parameters.xml -s state.xml --virtual";

/// A plan that is executed.
#[derive(Debug, Args)]
#[command(next_help_heading = "Executing a plan")]
pub(crate) struct PlannedArgs {
    /// Has the onboard planner turn this plan into the schedule, again and again.
    #[arg(long, value_name = "PLAN", requires_all = ["parameters", "state"])]
    #[arg(conflicts_with_all = ["journal", "mission"])]
    pub(crate) plan: Option<PathBuf>,
    /// What only the ground changes: limits, powers, preheat tables.
    #[arg(long, short, value_name = "FILE", requires = "plan")]
    pub(crate) parameters: Option<PathBuf>,
    /// What is so at the begin: charge, mode, communication windows.
    #[arg(long, short, value_name = "FILE", requires = "plan")]
    pub(crate) state: Option<PathBuf>,
    /// The plan that takes over at handover.
    #[arg(long, value_name = "PLAN", requires = "plan")]
    pub(crate) next: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// Which shell.
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}
