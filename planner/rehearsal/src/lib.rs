//! Rehearsals: plans executed on a simulated rover, faster than real time.
//!
//! Everything that flies is in it: the control thread, ticket agents with a
//! place for each running sequence and a gate for each unit, engine and heater,
//! and whoever plans. What is simulated is the rover, and time. Planner and
//! control thread see estimates alone; what really happened is in the
//! [`Trace`], for checkers.
//!
//! How long each activity takes and what becomes of it is drawn from a seed
//! *before* the execution: so two executions with the same seed, one that plans
//! again and one that does not, meet the same fate.
//!
//! | part | what |
//! |---|---|
//! | [`rehearse`], [`Setup`] | one execution |
//! | [`Draws`], [`Odds`] | what activities really take |
//! | [`Script`], [`Mishap`] | what goes wrong |
//! | [`Sequences`] | which units a sequence commands |
//! | [`Summary`], [`Won`] | what came of it |
//! | [`Setup::random`] | all of this, drawn from one number |
//! | [`campaign`] | many executions, counted |
//! | [`Breaks`] | what a checker must find |

#![forbid(unsafe_code)]

mod breaks;
pub mod campaign;
mod draws;
mod host;
mod model;
mod perform;
mod poll;
mod random;
mod rank;
mod record;
mod script;
mod sequences;
mod station;
mod summary;
mod throws;

use std::fmt;
use std::sync::Arc;

use faregate_devices_sim::SimClock;
use faregate_devices_sim::rover::{Rover, SWITCH_LAG, Senses};
use faregate_planner::execute::Options;
use faregate_planner::trace::Trace;
use faregate_planner::{Parameters, Plan, State, TimedPlan};
use faregate_tickets::clock::Duration;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;

pub use breaks::{Belief, Breaks};
pub use draws::{Draw, Draws, Odds};
pub use rank::ticket_priority;
pub use script::{Mishap, Script};
pub use sequences::Sequences;
pub use summary::{Summary, Won};

use host::Host;
use station::{Agents, Gates, Station};

/// One execution.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The plan.
    pub plan: Arc<Plan>,
    /// The parameters: what the planner believes.
    pub parameters: Arc<Parameters>,
    /// What is known at the begin.
    pub state: State,
    /// How the plan is executed.
    pub options: Options,
    /// What activities really take.
    pub draws: Draws,
    /// What goes wrong.
    pub script: Script,
    /// Which units sequences command.
    pub sequences: Sequences,
    /// The sensors.
    pub senses: Senses,
    /// The plan that takes over at handover, if it is there.
    pub next: Option<Arc<Plan>>,
    /// Decides what is drawn of the rover: noise, how fast zones warm.
    pub seed: u64,
    /// What is broken, so that checkers can be seen to find it.
    pub breaks: Breaks,
}

impl Setup {
    /// An execution of this plan with usual odds and nothing scripted, in which
    /// new plans are made as needed.
    #[must_use]
    pub fn new(plan: Arc<Plan>, parameters: Arc<Parameters>, state: State, seed: u64) -> Self {
        let capacity = state.capacity.get();
        let senses = Senses {
            charge_noise: faregate_tickets::amount::Microjoules::new(capacity / 1_000),
            ..Senses::default()
        };
        Self {
            draws: Draws::new(&plan, seed, &Odds::default()),
            plan,
            parameters,
            state,
            options: Options::default(),
            script: Script::default(),
            sequences: Sequences::default(),
            senses,
            next: None,
            seed,
            breaks: Breaks::default(),
        }
    }

    /// What the control thread believes.
    pub(crate) fn believed(&self) -> (Arc<Plan>, Arc<Parameters>) {
        match &self.breaks.believes {
            Some(belief) => (belief.plan.clone(), belief.parameters.clone()),
            None => (self.plan.clone(), self.parameters.clone()),
        }
    }

    /// The same, with a plan that takes over at handover, and usual odds for its
    /// activities.
    #[must_use]
    pub fn followed_by(mut self, next: Arc<Plan>) -> Self {
        self.draws.add(&next, self.seed, &Odds::default());
        self.next = Some(next);
        self
    }
}

/// Whoever plans.
pub trait Planner {
    /// A timed plan from this state; the incumbent's commit window is kept.
    ///
    /// # Errors
    /// Why there is none, in words: the plan and the parameters are unfit.
    fn plan(
        &mut self,
        plan: &Plan,
        parameters: &Parameters,
        state: &State,
        incumbent: Option<&TimedPlan>,
    ) -> Result<TimedPlan, String>;
}

impl<F> Planner for F
where
    F: FnMut(&Plan, &Parameters, &State, Option<&TimedPlan>) -> Result<TimedPlan, String>,
{
    fn plan(
        &mut self,
        plan: &Plan,
        parameters: &Parameters,
        state: &State,
        incumbent: Option<&TimedPlan>,
    ) -> Result<TimedPlan, String> {
        self(plan, parameters, state, incumbent)
    }
}

/// Why there was no rehearsal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotRehearsed {
    /// Whoever plans could not.
    NoPlan(String),
    /// The broker has no room for so many engines, units and heaters.
    TooManyGates,
    /// Nothing would ever happen again, and the plan is not over: a defect.
    StandsStill,
}

impl fmt::Display for NotRehearsed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPlan(why) => write!(f, "there is no plan to execute: {why}"),
            Self::TooManyGates => {
                f.write_str("engines, units and zones need more gates than one broker has")
            }
            Self::StandsStill => f.write_str("the execution stands still (a defect)"),
        }
    }
}

impl std::error::Error for NotRehearsed {}

/// Executes a plan from its state to its end; to that of the next plan, if it
/// took over.
///
/// # Errors
/// [`NotRehearsed`].
pub fn rehearse(setup: &Setup, planner: &mut dyn Planner) -> Result<Trace, NotRehearsed> {
    rehearse_watched(setup, planner, &mut |_| {})
}

/// The same, and tells each entry of the trace as it comes.
///
/// # Errors
/// [`NotRehearsed`].
pub fn rehearse_watched(
    setup: &Setup,
    planner: &mut dyn Planner,
    watch: &mut dyn FnMut(&faregate_planner::trace::Entry),
) -> Result<Trace, NotRehearsed> {
    let clock = SimClock::virtual_time();
    let (model, script) = (model::rover(setup), model::script(setup));
    let rover = Rover::new(model, script, setup.seed, &clock);
    let mut gates = Gates::new(&rover, setup, &clock).ok_or(NotRehearsed::TooManyGates)?;
    let mut broker = Box::new(Agents::new(clock.clone(), NoLane, NoNotify));
    let (parts, supervisor) =
        gates.register(&mut broker, setup).ok_or(NotRehearsed::TooManyGates)?;
    let station = Station::new(&broker, parts, supervisor, clock.clone(), rover.clone());
    clock.advance_to(model::instant(setup, setup.state.now));
    let first = planner
        .plan(&setup.plan, &setup.parameters, &setup.state, None)
        .map_err(NotRehearsed::NoPlan)?;
    Host::new(setup, rover, clock, station, first, watch).run(planner)
}

/// How far the rover's clock is ahead of the plan's: time to see every device
/// off.
const LEAD: Duration = Duration::from_millis(10);

const _: () = assert!(SWITCH_LAG.as_micros() < LEAD.as_micros());
