//! A control thread, driven by hand.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use faregate_planner::execute::{Action, Control, Event, Options};
use faregate_planner::parameters::{Load, Phase, PreheatRow, Zone};
use faregate_planner::plan::{Outcome, StartRange};
use faregate_planner::state::{Mode, State};
use faregate_planner::timed::{AwakePhase, Fate, Row, Slot, TimedPlan};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan};
use faregate_tickets::amount::{Microjoules, Milliwatts};

/// The plan's end.
pub(crate) const END: i64 = 600;
/// Activities of this priority and above are mandatory.
pub(crate) const MANDATORY: u32 = 100;
const CAPACITY: u64 = 360_000_000_000;

pub(crate) fn id(number: u32) -> ActivityId {
    ActivityId::new(number).expect("not 0")
}

pub(crate) const fn min(minutes: i64) -> Time {
    Time::new(minutes * 60_000)
}

pub(crate) const fn watts(watts: u32) -> Milliwatts {
    Milliwatts::from_watts(watts)
}

/// An optional activity of ten minutes and 20 W, that can start until minute
/// 100 and must be over at minute 200.
pub(crate) fn activity(number: u32) -> Activity {
    let starts = vec![StartRange { from: min(0), to: min(100), cutoff: min(200) }];
    Activity {
        starts,
        priority: 50,
        marginal: watts(20),
        peak: watts(40),
        engines: 1,
        ..Activity::new(id(number), Span::from_mins(10))
    }
}

pub(crate) fn mandatory(number: u32) -> Activity {
    Activity { priority: MANDATORY, ..activity(number) }
}

pub(crate) fn parameters() -> Parameters {
    let awake = Load { marginal: watts(50), peak: watts(60) };
    let phase = Phase { duration: Span::from_mins(5), load: awake };
    let table = vec![PreheatRow { from: Span::ZERO, duration: Span::from_mins(20) }];
    Parameters {
        mandatory_from: MANDATORY,
        soft_min_soc: Ppm::new(400_000),
        hard_min_soc: Ppm::new(200_000),
        max_soc: Ppm::new(950_000),
        peak_limit: watts(200),
        engines: 2,
        rtg: watts(110),
        base: watts(50),
        awake,
        wakeup: phase,
        shutdown: phase,
        min_awake: Span::from_mins(10),
        min_sleep: Span::from_mins(15),
        zones: vec![Zone { name: "mast".into(), load: awake, table }],
        commit: Span::from_mins(1),
        expansion_grace: Span::from_secs(30),
        handover_tolerance: Span::from_secs(5),
        soft_samples: 2,
        ..Parameters::default()
    }
}

/// Estimates hold for ever: most tests need none.
pub(crate) fn options() -> Options {
    Options { charge_holds: Span::new(i64::MAX), ..Options::default() }
}

pub(crate) struct Bench {
    pub(crate) control: Control,
    /// Whose tickets were asked for.
    asked: BTreeSet<ActivityId>,
}

impl Bench {
    /// Activities with their planned starts, in minutes; the computer is up all
    /// the time.
    pub(crate) fn new(activities: Vec<(Activity, i64)>) -> Self {
        Self::with(activities, parameters(), options(), |_, _| ())
    }

    pub(crate) fn with(
        activities: Vec<(Activity, i64)>,
        parameters: Parameters,
        options: Options,
        change: impl FnOnce(&mut Plan, &mut TimedPlan),
    ) -> Self {
        let rows = activities.iter().map(|(activity, at)| {
            let (start, end) = (min(*at), min(*at).after(activity.duration));
            Row { id: activity.id, fate: Fate::Scheduled(Slot { start, end, range: 0 }) }
        });
        let up = AwakePhase { wakeup: min(0), up: min(0), down: min(END), asleep: min(END) };
        let mut timed = TimedPlan { rows: rows.collect(), awake: vec![up], ..Default::default() };
        let mut plan = Plan {
            handover: min(END),
            end: min(END),
            max_delta_data: Bytes::new(1_000),
            activities: activities.into_iter().map(|(activity, _)| activity).collect(),
            ..Plan::default()
        };
        change(&mut plan, &mut timed);
        let state = State {
            mode: Mode::Awake,
            charge: Microjoules::new(CAPACITY * 8 / 10),
            capacity: Microjoules::new(CAPACITY),
            ..State::default()
        };
        let control = Control::new(Arc::new(plan), Arc::new(parameters), state, timed, options);
        Self { control, asked: BTreeSet::new() }
    }

    pub(crate) fn event(&mut self, at: Time, event: Event) -> Vec<Action> {
        let actions = self.control.step(at, event);
        for action in &actions {
            match action {
                Action::Request(id) => self.asked.insert(*id),
                Action::Withdraw(id) => self.asked.remove(id),
                _ => continue,
            };
        }
        actions
    }

    pub(crate) fn tick(&mut self, at: Time) -> Vec<Action> {
        self.event(at, Event::Tick)
    }

    /// So many hundredths of the capacity; the mast is warm or not.
    pub(crate) fn estimate(&mut self, at: Time, percent: u64, warm: bool) -> Vec<Action> {
        let charge = Microjoules::new(CAPACITY / 100 * percent);
        let zones = BTreeMap::from([("mast".to_owned(), warm)]);
        self.event(at, Event::Estimate { charge, zones })
    }

    /// It asks for its tickets, gets them, and starts.
    pub(crate) fn starts(&mut self, number: u32, at: Time) {
        let actions = self.tick(at);
        assert!(self.asked.contains(&id(number)), "{actions:?}");
        let started = self.event(at, Event::Granted(id(number)));
        assert!(is_started(&started, number), "{started:?}");
    }

    pub(crate) fn ends(&mut self, number: u32, at: Time, outcome: Outcome) -> Vec<Action> {
        self.event(at, Event::Ended(id(number), outcome, Bytes::ZERO))
    }

    pub(crate) fn runs(&self, number: u32) -> bool {
        self.control.state().running.iter().any(|running| running.id == id(number))
    }

    pub(crate) fn outcome(&self, number: u32) -> Option<Outcome> {
        let ended = &self.control.state().ended;
        ended.iter().find(|one| one.id == id(number)).map(|one| one.outcome)
    }
}

pub(crate) fn is_started(actions: &[Action], number: u32) -> bool {
    actions.iter().any(|action| matches!(action, Action::Start(one) if one.id == id(number)))
}

pub(crate) fn asks(actions: &[Action], number: u32) -> bool {
    actions.contains(&Action::Request(id(number)))
}

/// One millisecond before.
pub(crate) fn just_before(at: Time) -> Time {
    at.before(Span::new(1))
}
