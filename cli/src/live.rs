//! Sub-commands that talk to a running manager.

mod status;
mod watch;

use std::env;
use std::path::{Path, PathBuf};

use faregate_client::{Control, Error};

use crate::args::{AddArgs, ModeAction, RemoveArgs, SetArgs, SocketArgs, TaskArg, ToAllArgs};
use crate::exit::{Exit, Failure};
use crate::{disk, out};

pub(crate) use status::status;
pub(crate) use watch::watch;

/// Where a manager listens that was not told otherwise.
pub(crate) fn default_socket() -> PathBuf {
    let directory = env::var_os("XDG_RUNTIME_DIR").filter(|directory| !directory.is_empty());
    directory.map_or_else(|| PathBuf::from("."), PathBuf::from).join("faregate.sock")
}

impl SocketArgs {
    fn connect(&self) -> Result<Control, Failure> {
        // A variable that is empty is as good as none.
        let named = self.socket.as_ref().filter(|path| !path.is_empty()).map(PathBuf::from);
        let is_default = named.is_none();
        let path = named.unwrap_or_else(default_socket);
        Control::connect(&path).map_err(|error| advice(error, is_default))
    }
}

/// Where nobody listens, the next thing to try.
fn advice(error: Error, is_default: bool) -> Failure {
    match error {
        Error::NoPort(why) if is_default => Failure::Because(
            Exit::NoPort,
            format!(
                "{why}\nStart one with `faregate run FILE --socket PATH`, and say --socket PATH \
                 here too, or set FAREGATE_SOCKET."
            ),
        ),
        error => error.into(),
    }
}

pub(crate) fn add(args: &AddArgs) -> Result<Exit, Failure> {
    let files = args.files.iter().map(|path| {
        let name = name(path);
        Ok((name.clone(), name, read(path)?))
    });
    // A line has no name, and its format is known by one.
    let line = args
        .line
        .iter()
        .map(|line| Ok(("the line".to_owned(), "line.txt".to_owned(), format!("{line}\n"))));
    let schedules = files.chain(line).collect::<Result<Vec<_>, Failure>>()?;
    let mut control = args.socket.connect()?;
    for (shown, name, text) in schedules {
        control.add(&name, &text).map_err(|error| not_added(&shown, &error))?;
        out::line(format_args!("{shown}: added"))?;
    }
    Ok(Exit::Done)
}

fn not_added(name: &str, error: &Error) -> Failure {
    Failure::Because(Exit::from(error), format!("{name}: nothing of it was added: {error}"))
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn read(path: &Path) -> Result<String, Failure> {
    String::from_utf8(disk::read(path).map_err(Failure::failed)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Failure::failed(format!("{} is no UTF-8 text: byte {at} is none", path.display()))
    })
}

pub(crate) fn remove(args: &RemoveArgs) -> Result<Exit, Failure> {
    args.socket.connect()?.remove(&args.tasks)?;
    Ok(Exit::Done)
}

pub(crate) fn set(args: &SetArgs) -> Result<Exit, Failure> {
    let mut control = args.socket.connect()?;
    if let Some(priority) = args.priority {
        control.set_priority(args.task, priority)?;
    }
    if !args.windows.is_empty() {
        control.set_windows(args.task, &args.windows)?;
    }
    Ok(Exit::Done)
}

pub(crate) fn clear(args: &ToAllArgs) -> Result<Exit, Failure> {
    args.socket.connect()?.clear(args.all)?;
    Ok(Exit::Done)
}

pub(crate) fn hold(args: &TaskArg) -> Result<Exit, Failure> {
    args.socket.connect()?.hold(args.task)?;
    Ok(Exit::Done)
}

pub(crate) fn resume(args: &TaskArg) -> Result<Exit, Failure> {
    args.socket.connect()?.resume(args.task)?;
    Ok(Exit::Done)
}

pub(crate) fn mode(action: &ModeAction) -> Result<Exit, Failure> {
    match action {
        ModeAction::Enter(args) => args.socket.connect()?.enter_mode(&args.mode)?,
        ModeAction::Leave(args) => args.socket.connect()?.leave_mode(&args.mode)?,
    }
    Ok(Exit::Done)
}

pub(crate) fn shut_down(args: &SocketArgs) -> Result<Exit, Failure> {
    args.connect()?.shut_down()?;
    Ok(Exit::Done)
}
