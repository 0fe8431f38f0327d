//! Sub-commands for scripts inside a task: they speak over the command port
//! that the task's process inherited.

use faregate_client::CommandPort;

use crate::args::CommandArgs;
use crate::exit::{Exit, Failure};
use crate::out;

pub(crate) fn command(args: &CommandArgs) -> Result<Exit, Failure> {
    let arguments: Vec<&str> = args.arguments.iter().map(String::as_str).collect();
    let reply = CommandPort::from_env()?.command(&args.gate, &args.command, &arguments)?;
    if !reply.text.is_empty() {
        out::line(reply.text)?;
    }
    Ok(Exit::Done)
}

pub(crate) fn heartbeat() -> Result<Exit, Failure> {
    CommandPort::from_env()?.heartbeat()?;
    Ok(Exit::Done)
}
