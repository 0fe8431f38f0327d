//! The words of the command line.

mod live;
mod offline;
mod plan;

use clap::{Parser, Subcommand, ValueEnum};

pub(crate) use live::{
    AddArgs, CommandArgs, ModeAction, RemoveArgs, SetArgs, SocketArgs, StatusArgs, TaskArg,
    ToAllArgs, WatchArgs,
};
pub(crate) use offline::{
    AnalyzeArgs, CheckArgs, CompletionsArgs, ConflictColumn, ConvertArgs, FilesArgs, PlannedArgs,
    RunArgs,
};
pub(crate) use plan::{
    PlanAction, PlanCheckArgs, PlanConvertArgs, PlanDiffArgs, PlanMakeArgs, PlanNewArgs,
    PlanRunArgs, RunFormat, TableFormat, TemplateName,
};

/// The schedule manager and the onboard planner: what runs when, on tickets.
#[derive(Debug, Parser)]
#[command(name = "faregate", version, propagate_version = true, after_help = crate::exit::table())]
#[command(subcommand_required = true, arg_required_else_help = true)]
pub(crate) struct Faregate {
    #[command(subcommand)]
    pub(crate) what: What,
}

/// What is to be done.
#[derive(Debug, Subcommand)]
pub(crate) enum What {
    /// Reads schedules and missions, and reports everything that is wrong with
    /// them. Mistakes end with exit code 1, warnings alone with 0.
    Check(CheckArgs),
    /// Runs a schedule on a virtual clock, and tells what would run when, what
    /// would wait for whom, and what would never run.
    Analyze(AnalyzeArgs),
    /// Writes a schedule in another format, and lists what that cannot hold.
    Convert(ConvertArgs),
    /// Runs a schedule: processes, functions, sequences, on the mission's
    /// simulated devices. With a plan, the onboard planner makes the schedule.
    Run(RunArgs),
    /// Plans of the onboard planner.
    #[command(subcommand)]
    Plan(PlanAction),
    /// Tells where the tasks of a running manager stand.
    Status(StatusArgs),
    /// Tells every change at a running manager, until it ends.
    Watch(WatchArgs),
    /// Adds tasks to a running schedule, all or none.
    Add(AddArgs),
    /// Removes tasks from a running schedule. One that runs is aborted.
    Remove(RemoveArgs),
    /// Changes a task's priority or its windows.
    Set(SetArgs),
    /// Drops what is pending.
    Clear(ToAllArgs),
    /// Keeps a task from starting. One that runs is pre-empted.
    Hold(TaskArg),
    /// Lets a held task go on.
    Resume(TaskArg),
    /// Enters or leaves a mode of the mission.
    #[command(subcommand)]
    Mode(ModeAction),
    /// Ends everything that runs, in order, and the manager.
    Shutdown(SocketArgs),
    /// Inside a task: gives a command to a device, under the task's tickets.
    Command(CommandArgs),
    /// Inside a task: says that it is alive.
    Heartbeat,
    /// Prints what a shell needs to complete these words.
    Completions(CompletionsArgs),
}

/// How results are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For people.
    #[default]
    Text,
    /// For programs.
    Json,
}
