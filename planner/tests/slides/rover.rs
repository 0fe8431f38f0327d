//! A rover with round numbers: asleep it gains 80 W, awake 20 W.

use faregate_planner::parameters::{Day, Load, Parameters, Phase, PreheatRow, Zone};
use faregate_planner::plan::{Activity, ActivityId, Plan, StartRange};
use faregate_planner::state::State;
use faregate_planner::timed::{Fate, Limit, Reason, TimedPlan};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Problem, schedule};
use faregate_tickets::amount::{Microjoules, Milliwatts};

pub(crate) const MANDATORY: u32 = 100;

/// The plan, the parameters and the state, to be changed by a test.
#[derive(Clone)]
pub(crate) struct Rover {
    pub(crate) plan: Plan,
    pub(crate) parameters: Parameters,
    pub(crate) state: State,
}

pub(crate) fn id(number: u32) -> ActivityId {
    ActivityId::new(number).unwrap()
}

pub(crate) const fn min(minutes: i64) -> Time {
    Time::new(minutes * 60_000)
}

pub(crate) const fn watt_hours(wh: u64) -> Microjoules {
    Microjoules::new(wh * 3_600_000_000)
}

pub(crate) fn load(watts: u32) -> Load {
    Load { marginal: Milliwatts::from_watts(watts), peak: Milliwatts::from_watts(watts + 10) }
}

/// It can start between these two minutes.
pub(crate) fn activity(number: u32, minutes: i64, from: i64, to: i64) -> Activity {
    let mut it = Activity::new(id(number), Span::from_mins(minutes));
    it.starts = vec![StartRange { from: min(from), to: min(to), cutoff: min(100_000) }];
    it.priority = 10;
    it
}

pub(crate) fn drawing(watts: u32, activity: Activity) -> Activity {
    let power = Milliwatts::from_watts(watts);
    Activity { marginal: power, peak: power, ..activity }
}

pub(crate) fn rover(activities: Vec<Activity>) -> Rover {
    let phase = Phase { duration: Span::from_mins(5), load: load(40) };
    let row = |from, minutes| PreheatRow {
        from: Span::from_mins(from),
        duration: Span::from_mins(minutes),
    };
    let arm = Zone { name: "arm".into(), load: load(20), table: vec![row(0, 20), row(600, 10)] };
    let parameters = Parameters {
        mandatory_from: MANDATORY,
        soft_min_soc: Ppm::new(300_000),
        hard_min_soc: Ppm::new(200_000),
        max_soc: Ppm::new(900_000),
        peak_limit: Milliwatts::from_watts(300),
        engines: 2,
        rtg: Milliwatts::from_watts(100),
        base: Milliwatts::from_watts(20),
        awake: load(60),
        wakeup: phase,
        shutdown: phase,
        min_awake: Span::from_mins(10),
        min_sleep: Span::from_mins(30),
        day: Day::SOL,
        zones: vec![arm],
        commit: Span::from_mins(10),
        soft_samples: 1,
        ..Parameters::default()
    };
    let state = State {
        mode_since: min(-120),
        charge: watt_hours(600),
        capacity: watt_hours(1_000),
        ..State::default()
    };
    let plan = Plan {
        handover: min(1_200),
        end: min(1_200),
        max_delta_data: Bytes::new(1_000),
        activities,
        ..Plan::default()
    };
    Rover { plan, parameters, state }
}

impl Rover {
    pub(crate) fn problem(&self) -> Problem {
        Problem::new(&self.plan, &self.parameters, &self.state).unwrap()
    }

    pub(crate) fn timed(&self) -> TimedPlan {
        schedule(&self.problem(), None)
    }
}

/// Start and end in minutes.
pub(crate) fn slot(timed: &TimedPlan, number: u32) -> Option<(i64, i64)> {
    let slot = timed.slot(id(number))?;
    assert_eq!((slot.start.get() % 60_000, slot.end.get() % 60_000), (0, 0), "{slot:?}");
    Some((slot.start.get() / 60_000, slot.end.get() / 60_000))
}

pub(crate) fn reason(timed: &TimedPlan, number: u32) -> Reason {
    let row = timed.rows.iter().find(|row| row.id == id(number)).unwrap();
    match &row.fate {
        Fate::Out(reason) => reason.clone(),
        other => panic!("{number} is not left out: {other:?}"),
    }
}

pub(crate) fn limit(timed: &TimedPlan, number: u32) -> Limit {
    match reason(timed, number) {
        Reason::Limit { limit, .. } => limit,
        other => panic!("{number} is left out for no limit: {other:?}"),
    }
}

/// Each awake phase in minutes.
pub(crate) fn awake(timed: &TimedPlan) -> Vec<[i64; 4]> {
    let phases = timed.awake.iter();
    let phases = phases.map(|it| [it.wakeup, it.up, it.down, it.asleep]);
    phases.map(|phase| phase.map(|at| at.get() / 60_000)).collect()
}
