//! Sub-commands for scripts inside a task: they speak over the command port
//! that the task's process inherited.

use faregate_client::wire::command::Answer;
use faregate_client::{CommandPort, Error};

use crate::args::{CommandArgs, Format};
use crate::exit::{Exit, Failure};
use crate::out;

pub(crate) fn command(args: &CommandArgs) -> Result<Exit, Failure> {
    let arguments: Vec<&str> = args.arguments.iter().map(String::as_str).collect();
    let reply = CommandPort::from_env()?.command(&args.gate, &args.command, &arguments);
    match (args.format, reply) {
        (Format::Json, Ok(reply)) => out::json_line(&Answer::Done { reply: reply.text })?,
        (Format::Json, Err(Error::Refused(why))) => {
            out::json_line(&Answer::Refused(why.clone()))?;
            return Err(Failure::Said(Exit::from(&Error::Refused(why))));
        }
        (_, Ok(reply)) if reply.text.is_empty() => {}
        (_, Ok(reply)) => out::line(reply.text)?,
        (_, Err(error)) => return Err(error.into()),
    }
    Ok(Exit::Done)
}

pub(crate) fn heartbeat() -> Result<Exit, Failure> {
    CommandPort::from_env()?.heartbeat()?;
    Ok(Exit::Done)
}
