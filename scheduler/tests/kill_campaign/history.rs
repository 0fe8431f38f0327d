//! One history: lives of a manager in one place, all but the last killed.

use std::fs::File;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use faregate_scheduler::journal::points::Point;

use crate::{Break, Failure, checks};

/// How long a life may last. Far longer than one does on a loaded machine: it
/// ends managers that hang.
const LONGEST: Duration = Duration::from_secs(120);

/// Where a manager is to die.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Death {
    pub(crate) point: Point,
    pub(crate) visit: u64,
}

/// How often a manager came to each point that lived to its end.
pub(crate) type Visits = Vec<(Point, u64)>;

/// Lives until the schedule is over, dying these deaths on the way. Answers
/// which of them came, and the visits of the last life.
pub(crate) fn run(
    deaths: &[Death],
    broken: Option<Break>,
) -> Result<(Vec<Death>, Visits), Failure> {
    let directory = tempfile::tempdir()?;
    let place = directory.path();
    let mut died = Vec::new();
    let mut visits = None;
    for death in deaths {
        match live(place, Some(*death), broken)? {
            Life::Killed => died.push(*death),
            // It never came there: it is done.
            Life::Done(counted) => visits = Some(counted),
        }
    }
    let visits = match (visits, live(place, None, broken)?) {
        (_, Life::Killed) => return Err("a manager was killed that nobody killed".into()),
        (None, Life::Done(counted)) | (Some(counted), Life::Done(_)) => counted,
    };
    match checks::check(place) {
        Ok(()) => Ok((died, visits)),
        // What was broken on purpose need not be looked into.
        Err(error) if broken.is_some() => Err(error),
        Err(error) => {
            let kept = directory.keep();
            Err(format!("after {died:?}: {error}; see {}", kept.display()).into())
        }
    }
}

enum Life {
    Killed,
    Done(Visits),
}

fn live(place: &Path, death: Option<Death>, broken: Option<Break>) -> Result<Life, Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("manager").arg(place).stdin(Stdio::null()).env_remove("FAREGATE_KILL_POINT");
    // Files, not pipes: whoever outlives the manager could keep a pipe open.
    let [said, complained] = ["said", "complained"].map(|name| place.join(name));
    command.stdout(File::create(&said)?).stderr(File::create(&complained)?);
    if let Some(name) = broken.as_ref().and_then(ValueEnum::to_possible_value) {
        command.arg("--break").arg(name.get_name());
    }
    if let Some(Death { point, visit }) = death {
        command.env("FAREGATE_KILL_POINT", format!("{point}:{visit}"));
    }
    let status = wait(&mut command.spawn()?)?;
    if status.success() {
        let said = std::fs::read_to_string(said)?;
        return parse(&said).map(Life::Done).ok_or_else(|| format!("no census: {said:?}").into());
    }
    if death.is_some() && status.signal() == Some(9) {
        return Ok(Life::Killed);
    }
    let complained = std::fs::read_to_string(complained)?;
    Err(format!("a manager ended with {status}, with {death:?} before it: {complained}").into())
}

#[expect(clippy::disallowed_methods, reason = "another process is waited for, in real time")]
fn wait(child: &mut Child) -> Result<std::process::ExitStatus, Failure> {
    let since = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if since.elapsed() > LONGEST {
            child.kill()?;
            child.wait()?;
            return Err(format!("a manager did not come to its end within {LONGEST:?}").into());
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn parse(census: &str) -> Option<Visits> {
    let line = |line: &str| {
        let (name, visits) = line.split_once(' ')?;
        let point = Point::ALL.into_iter().find(|point| point.name() == name)?;
        Some((point, visits.parse().ok()?))
    };
    census.lines().map(line).collect()
}
