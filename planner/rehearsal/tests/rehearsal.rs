//! Executions on the simulated rover: with the planner, on tickets, and held
//! against the rules by the checker.

use std::collections::BTreeMap;
use std::sync::Arc;

use faregate_agents::Categories;
use faregate_planner::execute::Options;
use faregate_planner::parameters::{Load, Phase, PreheatRow, Zone};
use faregate_planner::plan::{Dependency, Kind, Outcome, StartRange, Status};
use faregate_planner::state::{Mode, State, Window};
use faregate_planner::trace::{Cause, Happened, Trace, Why};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan, Problem, TimedPlan, schedule};
use faregate_rehearsal::{Draw, Draws, Mishap, Odds, Script, Setup, Summary, Won, rehearse};
use faregate_tickets::amount::{Microjoules, Milliwatts};

fn planner(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
) -> Result<TimedPlan, String> {
    let problem = Problem::new(plan, parameters, state).map_err(|unfit| format!("{unfit:?}"))?;
    Ok(schedule(&problem, incumbent))
}

fn id(number: u32) -> ActivityId {
    ActivityId::new(number).expect("not 0")
}

const fn min(minutes: i64) -> Time {
    Time::new(minutes * 60_000)
}

const BIT: Categories = Categories::from_mask(1);

/// A mandatory activity of 20 minutes that can start in the first five hours.
fn activity(number: u32) -> Activity {
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

fn parameters() -> Parameters {
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

fn setup(activities: Vec<Activity>) -> Setup {
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

/// Executed, and no rule broken.
fn executed(setup: &Setup) -> Trace {
    let trace = rehearse(setup, &mut planner).expect("there is a plan");
    let wrong = faregate_checker::check_trace(&setup.plan, &setup.parameters, &trace);
    assert_eq!(wrong.iter().map(ToString::to_string).collect::<Vec<_>>(), [""; 0]);
    trace
}

fn when(trace: &Trace, is: impl Fn(&Happened) -> bool) -> Option<Time> {
    trace.entries.iter().find(|entry| is(&entry.what)).map(|entry| entry.at)
}

fn started(trace: &Trace, number: u32) -> Option<Time> {
    when(trace, |what| matches!(what, Happened::Dispatched(one) if one.id == id(number)))
}

fn ended(trace: &Trace, number: u32) -> Option<Time> {
    when(trace, |what| matches!(what, Happened::Ended { id: of, .. } if *of == id(number)))
}

fn early(share: u64) -> Draw {
    Draw { length: share, ..Draw::AS_PLANNED }
}

#[test]
fn equal_seeds_give_equal_executions_and_others_do_not() {
    let [a, b, c] = [1, 1, 2].map(|seed| {
        let plain = setup((1..5).map(activity).collect());
        let (plan, parameters) = (plain.plan, plain.parameters);
        executed(&Setup::new(plan, parameters, plain.state, seed))
    });
    assert_eq!(a, b);
    assert_ne!(a, c);
}

#[test]
fn what_ends_early_pulls_the_next_ones_in_and_the_plan_as_it_stands_does_not() {
    let mut ours = setup((1..6).map(activity).collect());
    for number in 1..6 {
        ours.draws.set(id(number), early(500));
    }
    let theirs = Setup { options: Options::STATIC, ..ours.clone() };
    let (here, there) = (executed(&ours), executed(&theirs));
    let length = |trace: &Trace, number| {
        ended(trace, number).and_then(|end| Some(end.since(started(trace, number)?)))
    };
    for number in 1..6 {
        assert_eq!(length(&here, number), Some(Span::from_mins(10)));
        assert_eq!(length(&there, number), Some(Span::from_mins(10)), "the same fate");
    }
    assert!(started(&here, 5) < started(&there, 5));
    let won = Won::between(&ours.plan, &here, &there);
    assert!(won.earlier_ms > 0 && won.awake_ms > 0 && won.energy_uj > 0, "{won:?}");
    let summary = Summary::of(&ours.plan, &here);
    assert!(summary.early_starts > 0 && summary.replans > 0, "{summary:?}");
}

#[test]
fn an_activity_that_fails_gets_its_cleanup_and_one_that_succeeds_does_not() {
    let after = vec![Dependency { prior: id(1), statuses: vec![Status::Failed, Status::Aborted] }];
    let cleanup = Activity { kind: Kind::Cleanup, after, ..activity(2) };
    let mut setup = setup(vec![activity(1), cleanup]);
    assert_eq!(Summary::of(&setup.plan, &executed(&setup)).cleanups, 0);
    setup.draws.set(id(1), Draw { succeeds: false, ..early(300) });
    let trace = executed(&setup);
    assert_eq!(Summary::of(&setup.plan, &trace).cleanups, 1);
    assert!(started(&trace, 2) >= ended(&trace, 1));
}

fn aborted(trace: &Trace, number: u32) -> Option<(usize, Cause)> {
    trace.entries.iter().enumerate().find_map(|(place, entry)| match entry.what {
        Happened::Aborted { id: of, cause, .. } if of == id(number) => Some((place, cause)),
        _ => None,
    })
}

#[test]
fn what_is_aborted_loses_its_tickets_and_its_devices_are_made_safe() {
    let mut setup = setup(vec![activity(1)]);
    let first = started(&executed(&setup), 1).expect("it starts");
    let at = first.after(Span::from_mins(3));
    setup.script = Script(vec![Mishap::Stop { at, id: id(1) }]);
    let trace = executed(&setup);
    let (place, cause) = aborted(&trace, 1).expect("it was ordered to stop");
    assert_eq!(cause, Cause::Ordered);
    let then: Vec<_> = trace.entries[place + 1..].iter().map(|entry| &entry.what).collect();
    assert_eq!(then[..2], [&Happened::Revoked(id(1)), &Happened::Safed(id(1))]);
    let load = then.iter().find_map(|what| match what {
        Happened::Truth(truth) => Some((truth.load, truth.engines)),
        _ => None,
    });
    assert_eq!(load, Some((Milliwatts::from_watts(80), 0)), "the computer alone");
}

#[test]
fn at_the_hard_limit_what_runs_is_aborted_and_the_computer_sleeps() {
    let mut setup = setup(vec![activity(1)]);
    let at = started(&executed(&setup), 1).expect("it starts").after(Span::from_mins(3));
    let energy = Microjoules::new(setup.state.capacity.get() / 100 * 70);
    setup.script = Script(vec![Mishap::Discharge { at, energy }]);
    let trace = executed(&setup);
    let (place, cause) = aborted(&trace, 1).expect("the charge is below it");
    assert_eq!(cause, Cause::HardLimit);
    let sleeps = Happened::Mode(Mode::ShuttingDown);
    assert!(trace.entries[place..].iter().any(|entry| entry.what == sleeps));
}

#[test]
fn tickets_that_somebody_takes_pause_what_can_be_paused() {
    let mut setup = setup(vec![Activity { pausable: true, ..activity(1) }]);
    let from = started(&executed(&setup), 1).expect("it starts").after(Span::from_mins(3));
    let until = from.after(Span::from_mins(7));
    let draw = Milliwatts::ZERO;
    setup.script = Script(vec![Mishap::Commandeered { from, until, draw, resources: BIT }]);
    let trace = executed(&setup);
    assert_eq!(when(&trace, |what| *what == Happened::Paused(id(1))), Some(from));
    let resumed = when(&trace, |what| *what == Happened::Resumed(id(1))).expect("they come back");
    assert!(resumed >= until);
    let ran = ended(&trace, 1).expect("it ends").since(resumed);
    assert_eq!(ran, Span::from_mins(17), "what was left of it");
}

#[test]
fn nothing_starts_in_a_zone_that_a_dead_heater_did_not_warm() {
    let mut setup = setup(vec![Activity { zones: vec!["mast".into()], ..activity(1) }]);
    let on_time = started(&executed(&setup), 1).expect("it starts");
    let (zone, from, until) = ("mast".to_owned(), min(0), on_time.after(Span::from_mins(30)));
    setup.script = Script(vec![Mishap::HeaterDead { zone, from, until }]);
    let trace = executed(&setup);
    let late = started(&trace, 1).expect("it is heated again");
    assert!(late > until, "{late}");
    let cold = |what: &Happened| matches!(what, Happened::Planned { why, .. } if why.contains(&Why::ZoneCold));
    assert!(when(&trace, cold).is_some());
}

#[test]
fn windows_that_change_are_planned_around_anew() {
    let mut setup = setup(vec![activity(1)]);
    let window = Window {
        name: "pass".into(),
        start: min(100),
        end: min(110),
        awake: true,
        marginal: Milliwatts::from_watts(40),
        peak: Milliwatts::from_watts(60),
        data: Bytes::new(-5),
        engines: 0,
        resources: Categories::NONE,
    };
    setup.state.windows = vec![window];
    let opens = |what: &Happened| matches!(what, Happened::Window { open: true, .. });
    assert_eq!(when(&executed(&setup), opens), Some(min(100)));
    setup.script = Script(vec![Mishap::Window { at: min(20), index: 0, becomes: None }]);
    assert_eq!(when(&executed(&setup), opens), None);
}

#[test]
fn every_activity_has_one_fate() {
    let setup = setup((1..8).map(activity).collect());
    let setup = Setup::new(setup.plan, setup.parameters, setup.state, 5);
    let mut fates: BTreeMap<ActivityId, u32> = BTreeMap::new();
    for entry in executed(&setup).entries {
        match entry.what {
            Happened::Ended { id, outcome, .. } => {
                assert!(matches!(outcome, Outcome::Succeeded | Outcome::Failed));
                *fates.entry(id).or_default() += 1;
            }
            Happened::Aborted { id, .. } | Happened::NotStarted { id, .. } => {
                *fates.entry(id).or_default() += 1;
            }
            _ => {}
        }
    }
    assert_eq!(fates, (1..8).map(|number| (id(number), 1)).collect());
}

#[test]
fn bad_days_break_no_rule() {
    let mut activities: Vec<_> = (1..9).map(activity).collect();
    for (number, one) in (1..).zip(&mut activities) {
        one.pausable = number % 3 == 0;
        one.priority = if number % 2 == 0 { 50 } else { 150 };
        one.resources = if number < 5 { BIT } else { Categories::NONE };
        one.starts[0].cutoff = min(if number == 1 { 45 } else { 400 });
    }
    let plain = setup(activities);
    let mut sum = Summary::default();
    for seed in 0..4 {
        let mut setup =
            Setup::new(plain.plan.clone(), plain.parameters.clone(), plain.state.clone(), seed);
        setup.draws = Draws::new(&setup.plan, seed, &Odds::HARSH);
        setup.script = Script::drawn(&setup.plan, &setup.parameters, &setup.state, seed);
        sum.add(&Summary::of(&setup.plan, &executed(&setup)));
    }
    let aborted: u64 = sum.aborted.values().sum();
    assert!(aborted > 0 && sum.early_starts > 0 && sum.failed > 0, "{sum:?}");
}
