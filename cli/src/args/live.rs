//! Words of the sub-commands that talk to a running manager.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::builder::OsStringValueParser;
use clap::{Args, Subcommand};

use faregate_client::wire::control::Window;

use super::Format;

/// Which manager.
#[derive(Debug, Args)]
pub(crate) struct SocketArgs {
    /// The manager's socket. Without it: $XDG_RUNTIME_DIR/faregate.sock, or
    /// ./faregate.sock.
    #[arg(long, value_name = "PATH", env = "FAREGATE_SOCKET", value_parser = OsStringValueParser::new())]
    pub(crate) socket: Option<OsString>,
}

#[derive(Debug, Args)]
pub(crate) struct StatusArgs {
    /// Of these tasks; without any: of all.
    #[arg(value_name = "TASK")]
    pub(crate) tasks: Vec<u32>,
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
    /// How changes are printed: lines, or a JSON document on each.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("tasks").required(true).args(["files", "line"])))]
pub(crate) struct AddArgs {
    /// Schedules: .csv, .txt or .toml. Each is added as a whole, or not at all.
    #[arg(value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// One task, as a line of a .txt schedule: id, st, et, dur, con, pri, type,
    /// interval, args.
    #[arg(long, value_name = "LINE", allow_hyphen_values = true)]
    pub(crate) line: Option<String>,
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
}

#[derive(Debug, Args)]
pub(crate) struct RemoveArgs {
    /// Which tasks.
    #[arg(required = true, value_name = "TASK")]
    pub(crate) tasks: Vec<u32>,
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
}

#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("change").required(true).multiple(true).args(["priority", "windows"])))]
pub(crate) struct SetArgs {
    /// Which task.
    #[arg(value_name = "TASK")]
    pub(crate) task: u32,
    /// Its priority from now on, 0 to 239.
    #[arg(long, short)]
    pub(crate) priority: Option<u8>,
    /// When it may start from now on: earliest..latest, each 0 for none, +SECONDS
    /// from now, RFC 3339 or Unix seconds. May be given several times.
    #[arg(long = "window", short, value_name = "ST..ET", value_parser = crate::times::window)]
    pub(crate) windows: Vec<Window>,
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ToAllArgs {
    /// Ends what runs, too.
    #[arg(long)]
    pub(crate) all: bool,
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
}

#[derive(Debug, Args)]
pub(crate) struct TaskArg {
    /// Which task.
    #[arg(value_name = "TASK")]
    pub(crate) task: u32,
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
}

/// What is done with a mode.
#[derive(Debug, Subcommand)]
pub(crate) enum ModeAction {
    /// Enters the mode.
    Enter(ModeArgs),
    /// Leaves the mode.
    Leave(ModeArgs),
}

#[derive(Debug, Args)]
pub(crate) struct ModeArgs {
    /// The mode's name.
    #[arg(value_name = "MODE")]
    pub(crate) mode: String,
    #[command(flatten)]
    pub(crate) socket: SocketArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CommandArgs {
    /// The gate of the device.
    #[arg(value_name = "GATE")]
    pub(crate) gate: String,
    /// The command.
    #[arg(value_name = "COMMAND")]
    pub(crate) command: String,
    /// Its arguments.
    #[arg(value_name = "ARGS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) arguments: Vec<String>,
    /// How the answer or the refusal is printed. What comes after COMMAND is the
    /// device's.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}
