//! What a plan is executed with, read from files and looked at before anything
//! starts.

use std::iter;
use std::sync::Arc;

use faregate_planner::tasks::{Director, Epoch, Library, Setting};
use faregate_planner::timed::Projection;
use faregate_planner::{Plan, Problem};
use faregate_scheduler::Mission;
use faregate_scheduler::format::Diagnostic;
use faregate_scheduler::time::UnixTime;

use super::Planned;
use crate::args::{FilesArgs, PlannedArgs};
use crate::exit::{Exit, Failure};
use crate::plan::input::{self, Inputs};
use crate::plan::mission;
use crate::report;
use crate::schedule::{self, Schedule, Source};

/// A plan that can be executed.
#[derive(Debug)]
pub(crate) struct Prepared {
    inputs: Inputs,
    next: Option<Plan>,
    library: Library,
    mission: Mission,
}

/// The mission alone, and the plan that brings it its tasks; nothing, where no
/// plan is given.
pub(crate) fn read(
    files: &FilesArgs,
    args: &PlannedArgs,
) -> Result<Option<(Schedule, Prepared)>, Failure> {
    let PlannedArgs { plan: Some(plan), parameters: Some(parameters), state: Some(state), next } =
        args
    else {
        return Ok(None);
    };
    let [file] = files.files.as_slice() else {
        let why = "with --plan there is one FILE: the mission, with the plan's sequences";
        return Err(Failure::Because(Exit::Usage, why.to_owned()));
    };
    let next = next.as_deref().map(|next| input::read(next, parameters, state)).transpose()?;
    let inputs = input::read(plan, parameters, state)?;
    let mut schedule = schedule::read(files)?;
    let source = Source::open(file)?;
    let next = next.map(|next| next.plan);
    let library = fitting(&inputs, next.as_ref(), source)?;
    let mission = schedule.mission.clone();
    schedule.tasks.clear();
    schedule.is_for(&inputs.plan.name);
    Ok(Some((schedule, Prepared { inputs, next, library, mission })))
}

/// The sequences in the mission's file, if the plans can be executed with them.
fn fitting(inputs: &Inputs, next: Option<&Plan>, source: Source) -> Result<Library, Failure> {
    let Inputs { plan, parameters, state } = inputs;
    let plans = iter::once(plan).chain(next);
    let found = mission::fits(Some(parameters), plans, &source)?;
    let library = Library::read(&source.name, &source.bytes);
    report::complain(&found, &[source]);
    if found.iter().any(Diagnostic::is_error) {
        return Err(Failure::Said(Exit::Failed));
    }
    Problem::new(plan, parameters, state).map_err(|unfit| crate::plan::unfit_for(&unfit))?;
    library.map_err(|why| Failure::failed(why.to_string()))
}

impl Prepared {
    /// The present instant of the state is this time of day.
    pub(crate) fn begin(self, wall: UnixTime) -> Planned {
        let Self { inputs: Inputs { plan, parameters, state }, next, library, mission } = self;
        let parameters = Arc::new(parameters);
        let passed = state.now.get().saturating_mul(1_000);
        let epoch = Epoch::new(UnixTime::from_micros(wall.as_micros().saturating_sub(passed)));
        let setting = Setting {
            plan: Arc::new(plan),
            parameters: Arc::clone(&parameters),
            library: Arc::new(library),
            mission: Arc::new(mission),
            epoch,
        };
        Planned {
            director: Director::new(setting, state),
            parameters,
            next: next.map(Arc::new),
            epoch,
            projection: Projection::default(),
            sample: None,
            plans: 0,
            not_planned: None,
        }
    }
}
