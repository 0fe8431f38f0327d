//! `plan make`: from a plan, parameters and a state to a timed plan.

mod document;
mod search;
mod table;

use std::path::Path;

use faregate_checker::Effort;
use faregate_planner::picture::{self, Scene};
use faregate_planner::plan::Kind;
use faregate_planner::timed::{Fate, Projection, Reason, Row};
use faregate_planner::words::Words;
use faregate_planner::{
    Activity, ActivityId, Parameters, Plan, Problem, State, TimedPlan, project,
};

use crate::args::{PlanMakeArgs, TableFormat};
use crate::exit::{Exit, Failure};
use crate::plan::input::{self, Inputs};
use crate::plan::make::search::{Explanations, Found, Search};
use crate::plan::unfit_for;
use crate::{disk, out};

/// Some mandatory activities are left out. The words were right all the same:
/// the number is that of wrong usage, and standard output tells them apart.
const SOME_OUT: Exit = Exit::Usage;

/// In plans of so many activities the checker looks for starts in sleeps, too:
/// it derives everything anew for each start that it tries.
const LOOKED_AT: usize = 100;
/// How many starts it tries in each stretch.
const GRID: u32 = 4;

/// A timed plan, and what there is to say of it.
#[derive(Debug)]
struct Made {
    plan: Plan,
    parameters: Parameters,
    state: State,
    timed: TimedPlan,
    projection: Projection,
    /// By the independent checker. There is none, or else the planner is wrong.
    violations: Vec<String>,
    explanations: Option<Explanations>,
    search: Option<Search>,
}

pub(super) fn make(args: &PlanMakeArgs) -> Result<Exit, Failure> {
    let Inputs { plan, parameters, state } =
        input::read(&args.plan, &args.parameters, &args.state)?;
    for path in args.out.iter().chain(&args.svg) {
        disk::can_be_written(path)?;
    }
    let problem = Problem::new(&plan, &parameters, &state).map_err(|unfit| unfit_for(&unfit))?;
    let incumbent = args.incumbent.as_deref().map(incumbent).transpose()?;
    let Found { timed, search } = search::best(&problem, incumbent.as_ref(), args)?;
    let violations = violations(&plan, &parameters, &state, incumbent.as_ref(), &timed);
    let explanations = args.explain.then(|| {
        let words = Words::new(&plan, &parameters);
        search::explanations(&problem, incumbent.as_ref(), &timed, &words)
    });
    let projection = project(&plan, &parameters, &state, &timed)
        .map_err(|unknown| Failure::failed(unknown.to_string()))?;
    let made =
        Made { plan, parameters, state, timed, projection, violations, explanations, search };
    // Whichever of the two fails, the other one is not lost.
    let written = write(args, &made);
    match args.format {
        TableFormat::Json => out::json(&document::document(&made))?,
        TableFormat::Table => table::print(&made)?,
    }
    written?;
    Ok(made.exit())
}

fn violations(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
    timed: &TimedPlan,
) -> Vec<String> {
    let effort = Effort { grid: if plan.activities.len() > LOOKED_AT { 0 } else { GRID } };
    let found = faregate_checker::check(plan, parameters, state, incumbent, timed, effort);
    found.iter().map(ToString::to_string).collect()
}

/// A timed plan that an earlier call wrote.
fn incumbent(path: &Path) -> Result<TimedPlan, Failure> {
    let name = path.display();
    let text = disk::read(path).map_err(Failure::failed)?;
    serde_json::from_slice(&text).map_err(|error| {
        Failure::failed(format!("{name} is no timed plan as --out writes it: {error}"))
    })
}

/// The files that were asked for.
fn write(args: &PlanMakeArgs, made: &Made) -> Result<(), Failure> {
    if let Some(path) = &args.out {
        let text = serde_json::to_string(&made.timed)
            .map_err(|error| Failure::failed(error.to_string()))?;
        disk::write(path, format!("{text}\n"))?;
    }
    let Some(path) = &args.svg else { return Ok(()) };
    let Made { plan, parameters, state, timed, projection, .. } = made;
    let scene = Scene { plan, parameters, state, timed, projection, trace: None };
    disk::write(path, picture::draw(&scene))
}

impl Made {
    fn words(&self) -> Words<'_> {
        Words::new(&self.plan, &self.parameters)
    }

    fn activity(&self, id: ActivityId) -> Option<&Activity> {
        self.plan.activities.iter().find(|activity| activity.id == id)
    }

    const fn is_mandatory(&self, activity: &Activity) -> bool {
        activity.priority >= self.parameters.mandatory_from
    }

    /// Mandatory, left out, and nobody can say that it is not needed.
    fn is_missed(&self, row: &Row) -> bool {
        let Fate::Out(reason) = &row.fate else { return false };
        let mandatory = self.activity(row.id).filter(|activity| self.is_mandatory(activity));
        let needless = matches!(reason, Reason::GroupTaken(_) | Reason::WaitsForOutcome(_));
        mandatory.is_some_and(|activity| activity.kind != Kind::Cleanup && !needless)
    }

    fn missed(&self) -> impl Iterator<Item = &Row> {
        self.timed.rows.iter().filter(|row| self.is_missed(row))
    }

    /// A plan that breaks a rule is no plan, however much is in it.
    fn exit(&self) -> Exit {
        if !self.violations.is_empty() {
            return Exit::Failed;
        }
        if self.missed().next().is_some() { SOME_OUT } else { Exit::Done }
    }
}
