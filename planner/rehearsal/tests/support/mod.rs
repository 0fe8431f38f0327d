//! A small world to execute plans in.

use std::sync::Arc;

use faregate_agents::Categories;
use faregate_planner::parameters::{Load, Phase, PreheatRow, Zone};
use faregate_planner::plan::StartRange;
use faregate_planner::state::{Mode, State};
use faregate_planner::trace::{Happened, Trace};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan, Problem, TimedPlan, schedule};
use faregate_rehearsal::{Draw, Draws, Setup};
use faregate_tickets::amount::{Microjoules, Milliwatts};

pub(crate) fn planner(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
) -> Result<TimedPlan, String> {
    let problem = Problem::new(plan, parameters, state).map_err(|unfit| format!("{unfit:?}"))?;
    Ok(schedule(&problem, incumbent))
}

pub(crate) fn id(number: u32) -> ActivityId {
    ActivityId::new(number).expect("not 0")
}

pub(crate) const fn min(minutes: i64) -> Time {
    Time::new(minutes * 60_000)
}

pub(crate) const BIT: Categories = Categories::from_mask(1);

/// A mandatory activity of 20 minutes that can start in the first five hours.
pub(crate) fn activity(number: u32) -> Activity {
    let starts = vec![StartRange { from: min(10), to: min(300), cutoff: min(400) }];
    Activity {
        starts,
        sequence: Some(format!("drive {number}")),
        priority: 200 - number,
        marginal: Milliwatts::from_watts(30),
        peak: Milliwatts::from_watts(60),
        engines: 1,
        resources: BIT,
        ..Activity::new(id(number), Span::from_mins(20))
    }
}

pub(crate) fn parameters() -> Parameters {
    let load = |w| Load { marginal: Milliwatts::from_watts(w), peak: Milliwatts::from_watts(w) };
    let phase = Phase { duration: Span::from_mins(5), load: load(60) };
    let table = vec![PreheatRow { from: Span::ZERO, duration: Span::from_mins(20) }];
    Parameters {
        mandatory_from: 100,
        soft_min_soc: Ppm::new(300_000),
        hard_min_soc: Ppm::new(150_000),
        max_soc: Ppm::new(950_000),
        peak_limit: Milliwatts::from_watts(300),
        engines: 8,
        rtg: Milliwatts::from_watts(110),
        base: Milliwatts::from_watts(50),
        awake: load(80),
        wakeup: phase,
        shutdown: phase,
        min_awake: Span::from_mins(10),
        min_sleep: Span::from_mins(20),
        zones: vec![Zone { name: "mast".into(), load: load(20), table }],
        commit: Span::from_mins(2),
        expansion_grace: Span::from_secs(60),
        handover_tolerance: Span::from_secs(2),
        soft_samples: 1,
        ..Parameters::default()
    }
}

pub(crate) fn setup(activities: Vec<Activity>) -> Setup {
    let end = min(600);
    let plan = Plan {
        handover: end,
        end,
        max_delta_data: Bytes::new(1 << 40),
        activities,
        ..Plan::default()
    };
    let capacity = 3_600_000_000 * 500;
    let state = State {
        mode: Mode::Asleep,
        mode_since: min(-60),
        charge: Microjoules::new(capacity / 10 * 8),
        capacity: Microjoules::new(capacity),
        ..State::default()
    };
    let mut setup = Setup::new(Arc::new(plan), Arc::new(parameters()), state, 1);
    setup.draws = Draws::default();
    setup
}

pub(crate) fn when(trace: &Trace, is: impl Fn(&Happened) -> bool) -> Option<Time> {
    trace.entries.iter().find(|entry| is(&entry.what)).map(|entry| entry.at)
}

pub(crate) fn started(trace: &Trace, number: u32) -> Option<Time> {
    when(trace, |what| matches!(what, Happened::Dispatched(one) if one.id == id(number)))
}

pub(crate) fn early(share: u64) -> Draw {
    Draw { length: share, ..Draw::AS_PLANNED }
}
