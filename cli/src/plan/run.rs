//! `plan run`: a plan, executed on a simulated rover.

mod campaign;
mod lines;
mod products;
mod script;
mod summary;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use faregate_checker::Violation;
use faregate_planner::execute::Options;
use faregate_planner::picture::{self, Scene};
use faregate_planner::project::project;
use faregate_planner::trace::{Happened, Trace};
use faregate_planner::words::Words;
use faregate_planner::{Parameters, Plan, Problem, State, TimedPlan, schedule};
use faregate_rehearsal::{Setup, Summary, Won, rehearse, rehearse_watched};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::args::{PlanRunArgs, RunFormat};
use crate::disk;
use crate::exit::{Exit, Failure};
use crate::out;
use crate::plan::input::{self, Inputs};
use lines::Lines;

/// What came of an execution.
#[derive(Debug, Serialize)]
struct Outcome<'a> {
    seed: u64,
    summary: &'a Summary,
    /// The first timed plan, executed as it stood, with the same draws.
    #[serde(rename = "static")]
    as_it_stood: Option<&'a Summary>,
    won: Option<&'a Won>,
    violations: &'a [String],
    trace: &'a Trace,
}

pub(super) fn run(args: &PlanRunArgs) -> Result<Exit, Failure> {
    let setup = setup(args)?;
    match args.campaign {
        Some(executions) => campaign::run(args, &setup, executions),
        None => run_once(args, &setup),
    }
}

/// Plans, in words where it cannot.
fn plan(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
) -> Result<TimedPlan, String> {
    let problem = Problem::new(plan, parameters, state).map_err(|unfit| {
        let all: Vec<String> = unfit.iter().map(ToString::to_string).collect();
        all.join("; ")
    })?;
    Ok(schedule(&problem, incumbent))
}

fn setup(args: &PlanRunArgs) -> Result<Setup, Failure> {
    let mut setup = match (&args.plan, &args.parameters, &args.state) {
        (Some(plan), Some(parameters), Some(state)) => of_files(args, plan, parameters, state)?,
        _ => Setup::random(args.seed),
    };
    if args.is_static {
        setup.options = Options::STATIC;
    }
    Ok(setup)
}

fn of_files(
    args: &PlanRunArgs,
    plan: &Path,
    parameters: &Path,
    state: &Path,
) -> Result<Setup, Failure> {
    let next = args.next.as_deref().map(|next| input::read(next, parameters, state));
    let Inputs { plan, parameters, state } = input::read(plan, parameters, state)?;
    let script = args.faults.as_deref().map(|path| script::read(path, &plan, &parameters, &state));
    let mut setup = Setup::new(Arc::new(plan), Arc::new(parameters), state, args.seed);
    setup.script = script.transpose()?.unwrap_or_default();
    Ok(match next.transpose()? {
        Some(next) => setup.followed_by(Arc::new(next.plan)),
        None => setup,
    })
}

fn run_once(args: &PlanRunArgs, setup: &Setup) -> Result<Exit, Failure> {
    if let Some(path) = &args.svg {
        disk::can_be_written(path)?;
    }
    args.products.as_deref().map_or(Ok(()), products::is_free)?;
    let trace = watched(args, setup)?;
    let as_it_stood = (!args.is_static).then(|| {
        let setup = Setup { options: Options::STATIC, ..setup.clone() };
        rehearse(&setup, &mut plan)
    });
    let as_it_stood = as_it_stood.transpose().map_err(not_rehearsed)?;
    let won = as_it_stood.as_ref().map(|theirs| Won::between(&setup.plan, &trace, theirs));
    let violations = violations(setup, &trace);
    if let Some(path) = &args.svg {
        disk::write(path, drawn(setup, &trace)?)?;
    }
    if let Some(directory) = &args.products {
        products::write(directory, setup, &trace)?;
    }
    let static_summary = as_it_stood.as_ref().map(|theirs| Summary::of(&setup.plan, theirs));
    let outcome = Outcome {
        seed: args.seed,
        summary: &Summary::of(&setup.plan, &trace),
        as_it_stood: static_summary.as_ref(),
        won: won.as_ref(),
        violations: &violations,
        trace: &trace,
    };
    match args.format {
        RunFormat::Json => out::json(&outcome)?,
        RunFormat::Text => summary::print(&outcome)?,
    }
    Ok(if violations.is_empty() { Exit::Done } else { Exit::Failed })
}

/// Executes it; a line for each change, or else progress where it takes long.
fn watched(args: &PlanRunArgs, setup: &Setup) -> Result<Trace, Failure> {
    let mut lines = Lines::new(setup);
    let mut gone = None;
    let mut bar = Progress::new(setup);
    let trace = rehearse_watched(setup, &mut plan, &mut |entry| {
        bar.at(entry.at.since(setup.state.now).get());
        let told = (args.format == RunFormat::Text).then(|| lines.line(entry)).flatten();
        if let Some(line) = told.filter(|_| gone.is_none()) {
            gone = out::line(line).err();
        }
    });
    bar.end();
    gone.map_or(Ok(()), Err)?;
    trace.map_err(not_rehearsed)
}

/// How much of the plan is over: shown when that takes more than a second and
/// nothing else is printed meanwhile.
struct Progress {
    began: Instant,
    length: u64,
    bar: ProgressBar,
}

impl Progress {
    fn new(setup: &Setup) -> Self {
        let length = setup.plan.end.since(setup.state.now).get() / 60_000;
        let length = u64::try_from(length).unwrap_or(0);
        Self { began: Instant::now(), length, bar: ProgressBar::hidden() }
    }

    fn at(&mut self, ms: i64) {
        if self.bar.is_hidden() && self.began.elapsed() > Duration::from_secs(1) {
            self.bar = ProgressBar::new(self.length);
            let style = "{bar:30} {pos} of {len} minutes of the plan";
            if let Ok(style) = ProgressStyle::with_template(style) {
                self.bar.set_style(style);
            }
        }
        self.bar.set_position(u64::try_from(ms / 60_000).unwrap_or(0));
    }

    fn end(&self) {
        self.bar.finish_and_clear();
    }
}

fn violations(setup: &Setup, trace: &Trace) -> Vec<String> {
    let found = faregate_checker::check_trace(&setup.plan, &setup.parameters, trace);
    let words = Words::new(&setup.plan, &setup.parameters);
    // With times of day, as in the lines above them.
    let said = |one: &Violation| {
        let text = one.to_string();
        let rest = text.strip_prefix(&format!("at {}", one.at)).unwrap_or_default();
        format!("at {}{rest}", words.time(one.at))
    };
    found.iter().map(said).collect()
}

/// What happened, over what was planned at first.
fn drawn(setup: &Setup, trace: &Trace) -> Result<String, Failure> {
    let Setup { plan, parameters, state, .. } = setup;
    let first = trace.entries.iter().find_map(|entry| match &entry.what {
        Happened::Planned { timed, .. } => Some(timed),
        _ => None,
    });
    let timed = first.map(|timed| TimedPlan::clone(timed)).unwrap_or_default();
    let projection = project(plan, parameters, state, &timed)
        .map_err(|unknown| Failure::failed(unknown.to_string()))?;
    let trace = Some(trace);
    let scene = Scene { plan, parameters, state, timed: &timed, projection: &projection, trace };
    Ok(picture::draw(&scene))
}

#[expect(clippy::needless_pass_by_value, reason = "it goes where errors are mapped")]
fn not_rehearsed(why: faregate_rehearsal::NotRehearsed) -> Failure {
    Failure::failed(why.to_string())
}
