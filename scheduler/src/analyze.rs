//! What will become of a schedule, said before it flies.
//!
//! [`analyze`] runs it on the [virtual executive](crate::executive), with the
//! durations that its tasks state, and tells when each task runs and what
//! should be looked at: who never runs, misses windows, waits for somebody less
//! important; which routine tasks collide, and how often; where wishes for draw
//! exceed a supply.
//!
//! It is the manager itself that decides, so there is no second opinion of how
//! it behaves. What the run assumes:
//!
//! - Every body succeeds, after its duration: one that states none takes no
//!   time. Starting, pausing, killing and handing over take none either. A
//!   checkpoint takes its grace.
//! - What is installed (memory, storage) is there, and the battery is full.
//! - A device is off as soon as its task has stopped: lags of estimates are not
//!   modelled.
//!
//! With [`Options::samples`], durations vary as the tasks say, and the report
//! tells what follows from it.

mod collide;
mod explain;
mod gantt;
pub mod pen;
mod phase;
mod problems;
mod report;
mod samples;
mod summary;
mod trace;
mod track;
mod utilisation;

pub use gantt::{Look, Rows, gantt};
pub use report::{Analysis, Picture, Problem, ProblemKind, Run, RunOutcome, TaskReport};
pub use samples::{Quantiles, Samples, TaskSamples};
pub use utilisation::{AgentUse, CategoryUse, Utilisation};

use core::fmt;

use faregate_agents::Categories;

use crate::analyze::trace::trace;
use crate::executive::{Conduct, LoadedFile, expected};
use crate::mission::{DeviceSpec, Mission};
use crate::task::Task;
use crate::time::{Duration, UnixTime};

/// How to look at a schedule.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// When it is loaded.
    pub at: UnixTime,
    /// How long to look; none: until the last task that is not routine has
    /// ended, or a day where there are routine tasks.
    pub horizon: Option<Duration>,
    /// One task at a time, whatever their categories.
    pub serial: bool,
    /// How many runs with drawn durations.
    pub samples: u32,
    /// What they are drawn by: the same seed draws the same.
    pub seed: u64,
}

/// More runs than these are not looked at, unless whoever asks wants it: a task
/// that comes each millisecond of a day would fill the memory.
pub const MOST_RUNS: usize = 2_000_000;

/// What an analysis wants of whoever asks for it.
pub trait Surroundings {
    /// Reads a schedule file that a task loads.
    fn load(&mut self, path: &str) -> LoadedFile {
        Err(format!("{path} is not read"))
    }

    /// The run has come so far, with so many attempts (or waits, where these are
    /// more), and goes on until then, where that is known. Answers whether it is to go on: what was looked at
    /// is reported then.
    fn reached(&mut self, at: Duration, limit: Option<Duration>, runs: usize) -> bool {
        let _ = (at, limit);
        runs < MOST_RUNS
    }

    /// So many samples of so many have been taken.
    fn sampled(&mut self, taken: u32, of: u32) {
        let _ = (taken, of);
    }
}

/// Reads no files, and wants to hear of no progress.
impl Surroundings for () {}

/// The manager did not accept the tasks, for this reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failed(pub String);

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the schedule cannot be analyzed: {}", self.0)
    }
}

impl core::error::Error for Failed {}

/// What becomes of these tasks, loaded together.
///
/// # Errors
/// When the manager does not accept them.
pub fn analyze(tasks: &[Task], mission: &Mission, options: &Options) -> Result<Analysis, Failed> {
    analyze_in(tasks, mission, options, &mut ())
}

/// The same with somebody who reads files, and hears of progress.
///
/// # Errors
/// When the manager does not accept the tasks.
pub fn analyze_in(
    tasks: &[Task],
    mission: &Mission,
    options: &Options,
    surroundings: &mut dyn Surroundings,
) -> Result<Analysis, Failed> {
    if options.serial {
        let (tasks, mission) = one_at_a_time(tasks, mission);
        return look(&tasks, &mission, options, surroundings);
    }
    look(tasks, mission, options, surroundings)
}

/// What every task commands, so that one at a time can run. Categories would
/// not do: a gap keeps them.
const TURN: &str = "(one at a time)";

fn one_at_a_time(tasks: &[Task], mission: &Mission) -> (Vec<Task>, Mission) {
    let mut tasks = tasks.to_vec();
    for task in &mut tasks {
        task.gates.push(TURN.into());
    }
    let mut mission = mission.clone();
    let agent = mission.agents.first().map(|agent| agent.name.clone()).unwrap_or_default();
    mission.devices.push(DeviceSpec {
        name: TURN.into(),
        kind: String::new(),
        agent,
        draw: None,
        categories: Categories::NONE,
        parameters: Default::default(),
    });
    (tasks, mission)
}

fn look(
    tasks: &[Task],
    mission: &Mission,
    options: &Options,
    surroundings: &mut dyn Surroundings,
) -> Result<Analysis, Failed> {
    let script = |_, task: &Task| Conduct::succeeds_after(expected(task));
    let mut trace = trace(tasks, mission, options, script, surroundings)?;
    trace.explain();
    let utilisation = utilisation::utilisation(&trace.tracks, mission, trace.horizon);
    let mut problems = problems::problems(&trace, &utilisation, options.at);
    let varies = tasks.iter().any(|task| task.spread.is_some());
    if options.samples > 0 && !varies {
        problems.push(problems::no_spread(options.samples));
    }
    let samples = if options.samples > 0 && varies {
        Some(samples::samples(tasks, mission, options, surroundings)?)
    } else {
        None
    };
    Ok(Analysis {
        makespan: trace.makespan(),
        horizon: trace.horizon,
        tasks: trace.tracks.into_iter().map(|track| track.report(trace.horizon)).collect(),
        problems,
        samples,
        utilisation,
    })
}
