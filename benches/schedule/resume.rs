//! Row 16: from the exec of a manager whose predecessor was killed until its
//! first decision, with 10 000 tasks in the schedule.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};

use faregate_runtime::clock::MonotonicClock;
use faregate_scheduler::time::Duration;
use faregate_tickets::clock::Clock;

use crate::scene::{brief, manager, place};
use crate::support::{Bench, Failure, Quantiles, Target};

/// Where the journal of a child is.
const JOURNAL: &str = "FAREGATE_BENCH_JOURNAL";
const TASKS: u32 = 10_000;
const RESUMPTIONS: u32 = 20;

/// The part of a child: goes on where the journal ends, says when it has
/// decided, and waits to be killed.
pub(crate) fn as_child() -> Option<ExitCode> {
    let directory = std::env::var_os(JOURNAL)?;
    match resume(Path::new(&directory)) {
        Ok(()) => Some(ExitCode::SUCCESS),
        Err(why) => {
            eprintln!("{why}");
            Some(ExitCode::FAILURE)
        }
    }
}

fn resume(directory: &Path) -> Result<(), Failure> {
    let (mut onboard, _) = manager(directory)?;
    if onboard.manager().status().next().is_none() {
        let due = Duration::from_secs(1_000_000);
        onboard.load((1..=TASKS).map(|number| brief(number, due)).collect())?;
    }
    onboard.turn()?;
    let tasks = onboard.manager().status().count();
    println!("{} {tasks}", MonotonicClock::new().now().as_micros());
    onboard.run(|_, _| false)?;
    Ok(())
}

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let home = place()?;
    // The first one fills the journal.
    decide(home.path())?;
    let resumptions = RESUMPTIONS.min(bench.rounds());
    let took: Result<Vec<_>, _> = (0..resumptions).map(|_| decide(home.path())).collect();
    let took = Quantiles::of(took?);
    let name = "resume after kill -9, 10 000 tasks, exec to first decision, worst";
    bench.figure(16, name, took.p999 / 1e6, "ms", Target::AtMost(100.0));
    bench.figure(16, "the same, median", took.median / 1e6, "ms", Target::None);
    Ok(())
}

/// Nanoseconds from the exec until the first decision. Then it is killed.
fn decide(home: &Path) -> Result<f64, Failure> {
    let began = MonotonicClock::new().now();
    let mut child =
        Command::new(std::env::current_exe()?).env(JOURNAL, home).stdout(Stdio::piped()).spawn()?;
    let said = listen(&mut child);
    child.kill()?;
    child.wait()?;
    let (decided, tasks) = said?;
    if tasks != TASKS {
        return Err(format!("it went on with {tasks} of {TASKS} tasks").into());
    }
    Ok(decided.saturating_sub(began.as_micros()) as f64 * 1e3)
}

fn listen(child: &mut Child) -> Result<(u64, u32), Failure> {
    let out = child.stdout.take().ok_or("no output")?;
    let mut line = String::new();
    BufReader::new(out).read_line(&mut line)?;
    let (decided, tasks) = line.trim().split_once(' ').ok_or("the manager said nothing")?;
    Ok((decided.parse()?, tasks.parse()?))
}
