//! Executions on the simulated rover: with the planner, on tickets, and held
//! against the rules by the checker.

mod support;

use std::collections::BTreeMap;
use std::sync::Arc;

use faregate_agents::Categories;
use faregate_planner::execute::Options;
use faregate_planner::plan::{Dependency, Kind, Outcome, Status};
use faregate_planner::state::{Mode, Window};
use faregate_planner::trace::{Cause, Happened, Trace, Why};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan};
use faregate_rehearsal::{Draw, Draws, Mishap, Odds, Script, Setup, Summary, Won, rehearse};
use faregate_tickets::amount::{Microjoules, Milliwatts};
use support::{BIT, activity, early, id, min, planner, setup, started, when};

/// Executed, and no rule broken.
fn executed(setup: &Setup) -> Trace {
    let trace = rehearse(setup, &mut planner).expect("there is a plan");
    let wrong = faregate_checker::check_trace(&setup.plan, &setup.parameters, &trace);
    assert_eq!(wrong.iter().map(ToString::to_string).collect::<Vec<_>>(), [""; 0]);
    trace
}

fn ended(trace: &Trace, number: u32) -> Option<Time> {
    when(trace, |what| matches!(what, Happened::Ended { id: of, .. } if *of == id(number)))
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
    // Else whoever is done sooner may be up longer: a full battery ends its sleep.
    let max_soc = Ppm::new(1_000_000);
    ours.parameters = Arc::new(Parameters { max_soc, ..Parameters::clone(&ours.parameters) });
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

/// A gauge that is silent, while the charge falls below the hard limit.
fn falls_in_silence() -> Setup {
    let mut setup = setup(vec![Activity { duration: Span::from_mins(60), ..activity(1) }]);
    let at = started(&executed(&setup), 1).expect("it starts").after(Span::from_mins(3));
    let energy = Microjoules::new(setup.state.capacity.get() / 100 * 70);
    let until = at.after(Span::from_mins(90));
    setup.script = Script(vec![
        Mishap::SensorsSilent { from: at, until },
        Mishap::Discharge { at: at.after(Span::from_secs(1)), energy },
    ]);
    setup
}

#[test]
fn when_the_gauge_is_silent_for_too_long_what_draws_is_aborted() {
    let setup = falls_in_silence();
    let trace = executed(&setup);
    let (place, cause) = aborted(&trace, 1).expect("nobody knows the charge");
    assert_eq!(cause, Cause::ChargeUnknown);
    let Mishap::Discharge { at, .. } = setup.script.0[1] else { panic!("it is one") };
    let blind = trace.entries[place].at.since(at);
    assert!(blind <= trace.charge_lag, "{blind}");
}

#[test]
fn who_trusts_an_estimate_for_hours_runs_on_at_the_hard_limit_and_is_caught() {
    let mut setup = falls_in_silence();
    let trusted = setup.options.charge_holds;
    setup.options.charge_holds = Span::from_mins(200);
    let mut trace = rehearse(&setup, &mut planner).expect("there is a plan");
    assert_eq!(aborted(&trace, 1), None, "it does not know better");
    let rules = |trace: &Trace| -> Vec<_> {
        let wrong = faregate_checker::check_trace(&setup.plan, &setup.parameters, trace);
        wrong.into_iter().map(|violation| violation.rule).collect()
    };
    // What was promised to be trusted no longer than usual.
    trace.charge_lag = Span::new(trusted.get() + 2_000);
    trace.charge_holds = Some(trusted);
    let found = rules(&trace);
    for rule in [faregate_checker::Rule::RanAtHardLimit, faregate_checker::Rule::RanBlind] {
        assert!(found.contains(&rule), "{rule:?}: {found:?}");
    }
}

#[test]
fn the_next_plan_takes_over_and_is_executed_to_its_end() {
    let mut setup = setup(vec![activity(1), activity(2)]);
    let first = Plan::clone(&setup.plan);
    let at = started(&executed(&setup), 1).expect("it starts").after(Span::from_mins(5));
    setup.plan = Arc::new(Plan { handover: at, next_plan: Some("next".into()), ..first.clone() });
    let next = Plan { end: min(700), handover: min(700), activities: vec![activity(7)], ..first };
    let trace = executed(&setup.followed_by(Arc::new(next)));
    assert_eq!(trace.end, min(700));
    let took_over = |what: &Happened| matches!(what, Happened::HandedOver(_));
    assert_eq!(when(&trace, took_over), Some(at));
    assert!(ended(&trace, 1) > Some(at), "what runs stays");
    assert!(started(&trace, 7) > Some(at));
    assert_eq!(started(&trace, 2), None, "what had not begun is dropped");
}

#[test]
fn a_rover_that_sleeps_at_handover_is_woken_to_time_the_next_plan() {
    let mut setup = setup(vec![activity(1)]);
    let first = Plan::clone(&setup.plan);
    setup.plan =
        Arc::new(Plan { handover: min(200), next_plan: Some("next".into()), ..first.clone() });
    let mut later = activity(7);
    later.starts[0].to = min(500);
    later.starts[0].cutoff = min(550);
    let next = Plan { activities: vec![later], ..first };
    let trace = executed(&setup.followed_by(Arc::new(next)));
    let entries = trace.entries.iter();
    let up = entries.filter(|entry| entry.what == Happened::Mode(Mode::WakingUp));
    assert!(up.into_iter().any(|entry| entry.at == min(200)));
    assert!(started(&trace, 7).is_some());
}

/// As many as `EXECUTIONS` says: each seed is another world.
#[test]
fn random_executions_break_no_rule() {
    let executions = std::env::var("EXECUTIONS").ok().and_then(|text| text.parse().ok());
    let mut sum = Summary::default();
    for seed in 0..executions.unwrap_or(60) {
        let setup = Setup::random(seed);
        let trace = rehearse(&setup, &mut planner).expect("there is a plan");
        let wrong = faregate_checker::check_trace(&setup.plan, &setup.parameters, &trace);
        let wrong: Vec<_> = wrong.iter().map(ToString::to_string).collect();
        assert_eq!(wrong, [""; 0], "seed {seed}");
        sum.add(&Summary::of(&setup.plan, &trace));
    }
    assert!(sum.succeeded > 0 && sum.failed > 0 && sum.handovers > 0, "{sum:?}");
}
