//! Slides "Planner wakeup, awake, shutdown" and "Preheat": what the planner
//! generated, as it becomes due.

use faregate_planner::execute::{Action, Event};
use faregate_planner::plan::{Kind, Outcome, StartRange};
use faregate_planner::state::{Mode, Window};
use faregate_planner::timed::{AwakePhase, Preheat, TimedPlan};
use faregate_planner::trace::Unstarted;
use faregate_planner::units::Span;
use faregate_planner::{Activity, Plan};

use crate::bench::{Bench, activity, id, min, options, parameters};

const FIVE: Span = Span::from_mins(5);

/// Up to minute 30, and again from minute 105 on.
fn sleeps(_: &mut Plan, timed: &mut TimedPlan) {
    let phase = |wakeup, up, down, asleep| AwakePhase {
        wakeup: min(wakeup),
        up: min(up),
        down: min(down),
        asleep: min(asleep),
    };
    timed.awake = vec![phase(0, 0, 30, 35), phase(100, 105, 150, 155)];
}

fn bench(activities: Vec<(Activity, i64)>) -> Bench {
    Bench::with(activities, parameters(), options(), sleeps)
}

#[test]
fn the_computer_is_shut_down_and_woken_as_planned() {
    let mut bench = bench(Vec::new());
    assert!(bench.tick(min(30)).contains(&Action::ShutDown(FIVE)));
    bench.event(min(35), Event::Mode(Mode::Asleep));
    assert_eq!(bench.control.due(), Some(min(100)));
    assert!(bench.tick(min(100)).contains(&Action::Wake(FIVE)));
}

#[test]
fn what_still_runs_keeps_it_up() {
    let mut bench = bench(vec![(crate::bench::mandatory(1), 25)]);
    bench.starts(1, min(25));
    assert!(!bench.tick(min(30)).contains(&Action::ShutDown(FIVE)));
    let actions = bench.ends(1, min(40), Outcome::Succeeded);
    assert!(actions.contains(&Action::ShutDown(FIVE)), "{actions:?}");
}

#[test]
fn a_sleep_that_would_be_too_short_is_not_begun() {
    let mut bench = bench(vec![(crate::bench::mandatory(1), 25)]);
    bench.starts(1, min(25));
    bench.tick(min(30));
    // 14 minutes are less than the shortest sleep.
    let actions = bench.ends(1, min(81), Outcome::Succeeded);
    assert!(!actions.contains(&Action::ShutDown(FIVE)), "{actions:?}");
}

#[test]
fn at_the_hard_limit_it_is_shut_down() {
    let mut bench = bench(vec![(activity(1), 10)]);
    bench.starts(1, min(10));
    let actions = bench.estimate(min(12), 19, true);
    assert!(actions.contains(&Action::ShutDown(FIVE)), "{actions:?}");
}

#[test]
fn zones_are_heated_as_planned() {
    let heated = |plan: &mut Plan, timed: &mut TimedPlan| {
        sleeps(plan, timed);
        timed.preheats = vec![Preheat { zone: "mast".into(), start: min(2), end: min(20) }];
    };
    let mut bench = Bench::with(Vec::new(), parameters(), options(), heated);
    let heat = |on| Action::Heat { zone: "mast".into(), on };
    assert!(bench.tick(min(2)).contains(&heat(true)));
    assert_eq!(bench.control.state().heating.get("mast"), Some(&min(2)));
    assert!(bench.tick(min(20)).contains(&heat(false)));
}

/// From minute 20 to minute 80.
fn block() -> (Activity, i64) {
    let kind = Kind::ManualShutdown { shutdown: FIVE, wakeup: FIVE };
    let starts = vec![StartRange { from: min(20), to: min(20), cutoff: min(80) }];
    (Activity { kind, starts, duration: Span::from_mins(60), ..activity(9) }, 20)
}

#[test]
fn a_manual_block_comes_before_everything_else() {
    let mut bench = Bench::new(vec![(crate::bench::mandatory(1), 15), block()]);
    bench.starts(1, min(15));
    let actions = bench.tick(min(20));
    assert!(actions.contains(&Action::ShutDown(FIVE)), "{actions:?}");
    assert_eq!(bench.outcome(1), Some(Outcome::Aborted));
    bench.event(min(25), Event::Mode(Mode::Asleep));
    assert!(bench.tick(min(75)).contains(&Action::Wake(FIVE)));
    assert!(bench.tick(min(80)).contains(&Action::BlockOver(id(9))));
}

#[test]
fn a_manual_block_that_was_vetoed_is_none_and_one_that_has_begun_is_not_vetoed() {
    let mut bench = Bench::new(vec![block()]);
    let vetoed = Action::NotStarted(id(9), Unstarted::Vetoed);
    assert!(bench.event(min(10), Event::Veto(id(9))).contains(&vetoed));
    assert!(!bench.tick(min(20)).contains(&Action::ShutDown(FIVE)));
    assert_ne!(bench.control.due(), Some(min(75)), "nobody wakes up from it");

    let mut bench = Bench::new(vec![block()]);
    assert!(bench.tick(min(20)).contains(&Action::ShutDown(FIVE)));
    bench.event(min(25), Event::Mode(Mode::Asleep));
    assert!(!bench.event(min(30), Event::Veto(id(9))).contains(&vetoed));
    assert!(bench.tick(min(75)).contains(&Action::Wake(FIVE)));
}

#[test]
fn no_window_wakes_the_computer_in_a_manual_block() {
    let window = Window {
        name: "pass".into(),
        start: min(30),
        end: min(90),
        awake: true,
        marginal: Default::default(),
        peak: Default::default(),
        data: Default::default(),
        engines: 0,
        resources: Default::default(),
    };
    let mut bench = Bench::new(vec![block()]);
    bench.event(min(10), Event::Windows(vec![window]));
    assert!(bench.tick(min(20)).contains(&Action::ShutDown(FIVE)));
    bench.event(min(25), Event::Mode(Mode::Asleep));
    let wakes = |actions: &[Action]| actions.contains(&Action::Wake(FIVE));
    assert!(!wakes(&bench.tick(min(30))));
    assert!(wakes(&bench.tick(min(75))), "the block's own wakeup");
}
