//! A task's process: writes down that it began, turns the camera on if it is to
//! take pictures, takes its time, and writes down that it ends.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

use clap::Args;
use faregate_client::CommandPort;

use crate::Failure;
use crate::device::CAMERA;
use crate::truth::{Chronicle, Fact, Try};

/// What a task's process does.
#[derive(Debug, Args)]
pub(crate) struct Conduct {
    /// Where everything is.
    place: PathBuf,
    /// How long it takes, in milliseconds.
    #[arg(long)]
    takes: u64,
    /// Whether it turns the camera on. It leaves it on: whoever gave it the
    /// ticket sees to it.
    #[arg(long)]
    camera: bool,
    /// Whether it starts a process in a group of its own and forgets it.
    #[arg(long)]
    leaves: bool,
    /// It is such a process: it writes nothing, and stays for very long.
    #[arg(long)]
    left: bool,
}

/// Longer than a history. It ends by itself all the same, one day.
const LONG: Duration = Duration::from_secs(600);

pub(crate) fn run(conduct: &Conduct) -> Result<ExitCode, Failure> {
    if conduct.left {
        work(LONG);
        return Ok(ExitCode::SUCCESS);
    }
    let mut chronicle = Chronicle::open(&conduct.place)?;
    let own = Try {
        task: from_environment("FAREGATE_TASK")?,
        occurrence: from_environment("FAREGATE_OCCURRENCE")?,
        attempt: from_environment("FAREGATE_ATTEMPT")?,
        process: std::process::id(),
    };
    chronicle.note(&Fact::Began(own))?;
    if conduct.leaves {
        leave_somebody(&conduct.place)?;
    }
    let refused = conduct.camera
        && CommandPort::from_env()?.command(CAMERA, "on", &[]).is_err_and(|error| {
            eprintln!("the camera does not obey: {error}");
            true
        });
    work(Duration::from_millis(conduct.takes));
    let code = u8::from(refused);
    chronicle.note(&Fact::Ended(own, code.into()))?;
    Ok(code.into())
}

fn leave_somebody(place: &Path) -> Result<(), Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("task").arg(place).args(["--takes", "0", "--left"]).process_group(0);
    drop(command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?);
    Ok(())
}

#[expect(clippy::disallowed_methods, reason = "the work of this process is to take real time")]
fn work(time: Duration) {
    std::thread::sleep(time);
}

fn from_environment<T: std::str::FromStr>(name: &str) -> Result<T, Failure> {
    let text = std::env::var(name).map_err(|_| format!("{name} is not set"))?;
    text.parse().map_err(|_| format!("{name} is {text:?}").into())
}
