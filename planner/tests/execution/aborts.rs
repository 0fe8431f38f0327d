//! Slide "The planner aborts an activity when", and "The effects of an abort".

use faregate_planner::execute::{Action, NotReady};
use faregate_planner::plan::{Kind, Outcome};
use faregate_planner::state::{Mode, Window};
use faregate_planner::trace::{Cause, Why};
use faregate_planner::units::Span;
use faregate_planner::{Activity, execute::Event};
use faregate_tickets::amount::Milliwatts;

use crate::bench::{Bench, activity, id, just_before, mandatory, min};

fn aborted(actions: &[Action], number: u32) -> Option<Cause> {
    actions.iter().find_map(|action| match action {
        Action::Abort(of, cause) if *of == id(number) => Some(*cause),
        _ => None,
    })
}

#[test]
fn it_has_not_finished_by_its_absolute_cutoff_time() {
    let mut bench = Bench::new(vec![(mandatory(1), 0)]);
    bench.starts(1, min(0));
    assert_eq!(aborted(&bench.tick(just_before(min(200))), 1), None);
    assert_eq!(aborted(&bench.tick(min(200)), 1), Some(Cause::Cutoff));
    assert_eq!(bench.outcome(1), Some(Outcome::Aborted));
}

#[test]
fn it_is_running_when_we_hit_the_hard_state_of_charge_limit() {
    let idle = Activity { marginal: Milliwatts::ZERO, ..mandatory(2) };
    let mut bench = Bench::new(vec![(mandatory(1), 0), (idle, 0)]);
    bench.starts(1, min(0));
    bench.starts(2, min(0));
    assert_eq!(aborted(&bench.estimate(min(1), 20, true), 1), None, "the limit is not below it");
    let actions = bench.estimate(min(2), 19, true);
    assert_eq!(aborted(&actions, 1), Some(Cause::HardLimit));
    assert_eq!(aborted(&actions, 2), None, "it draws nothing");
}

#[test]
fn an_optional_one_is_running_past_the_soft_state_of_charge_limit() {
    let mut bench = Bench::new(vec![(activity(1), 0), (mandatory(2), 0)]);
    bench.starts(1, min(0));
    bench.starts(2, min(0));
    assert_eq!(aborted(&bench.estimate(min(1), 39, true), 1), None, "one sample of two");
    assert_eq!(aborted(&bench.estimate(min(2), 40, true), 1), None, "at the limit");
    assert_eq!(aborted(&bench.estimate(min(3), 39, true), 1), None, "not in a row");
    let actions = bench.estimate(min(4), 39, true);
    assert_eq!(aborted(&actions, 1), Some(Cause::SoftLimit));
    assert!(bench.runs(2), "mandatory are allowed to execute past it if already dispatched");
}

#[test]
fn an_optional_one_is_running_past_its_duration() {
    let mut bench = Bench::new(vec![(activity(1), 0), (mandatory(2), 0)]);
    bench.starts(1, min(0));
    bench.starts(2, min(0));
    assert_eq!(aborted(&bench.tick(just_before(min(10))), 1), None);
    assert_eq!(aborted(&bench.tick(min(10)), 1), Some(Cause::Duration));
    bench.tick(min(90));
    assert!(bench.runs(2));
}

#[test]
fn one_that_ends_in_time_is_not_aborted() {
    let mut bench = Bench::new(vec![(activity(1), 0)]);
    bench.starts(1, min(0));
    assert_eq!(aborted(&bench.ends(1, min(10), Outcome::Succeeded), 1), None);
    assert_eq!(bench.outcome(1), Some(Outcome::Succeeded));
}

#[test]
fn an_expanding_one_is_told_to_end_and_has_a_grace() {
    let kind = Kind::Expanding { minimum: Span::from_mins(2) };
    let mut bench = Bench::new(vec![(Activity { kind, ..activity(1) }, 0)]);
    bench.starts(1, min(0));
    let actions = bench.tick(min(10));
    assert_eq!(actions.iter().filter(|one| **one == Action::TellToEnd(id(1))).count(), 1);
    let over = min(10).after(Span::from_secs(30));
    let actions = bench.tick(just_before(over));
    assert!(!actions.contains(&Action::TellToEnd(id(1))), "it was told once");
    assert_eq!(aborted(&actions, 1), None);
    assert_eq!(aborted(&bench.tick(over), 1), Some(Cause::Duration));
}

#[test]
fn an_expanding_one_that_ends_in_its_grace_has_succeeded() {
    let kind = Kind::Expanding { minimum: Span::from_mins(2) };
    let mut bench = Bench::new(vec![(Activity { kind, ..activity(1) }, 0)]);
    bench.starts(1, min(0));
    bench.tick(min(10));
    let actions = bench.ends(1, min(10).after(Span::from_secs(29)), Outcome::Succeeded);
    assert_eq!(aborted(&actions, 1), None);
    assert_eq!(bench.outcome(1), Some(Outcome::Succeeded));
}

#[test]
fn at_the_hard_limit_the_computer_stays_up_for_a_window_that_needs_it() {
    let window = |awake| Window {
        name: "pass".into(),
        start: min(1),
        end: min(20),
        awake,
        marginal: Milliwatts::ZERO,
        peak: Milliwatts::ZERO,
        data: Default::default(),
        engines: 0,
        resources: Default::default(),
    };
    for awake in [true, false] {
        let mut bench = Bench::new(vec![(mandatory(1), 0)]);
        bench.starts(1, min(0));
        bench.event(min(1), Event::Windows(vec![window(awake)]));
        let actions = bench.estimate(min(2), 19, true);
        assert_eq!(aborted(&actions, 1), Some(Cause::HardLimit));
        let is_down =
            |actions: &[Action]| actions.iter().any(|it| matches!(it, Action::ShutDown(_)));
        assert_eq!(is_down(&actions), !awake);
        assert_eq!(is_down(&bench.tick(min(20))), awake, "and no longer than for that");
    }
}

#[test]
fn an_aborted_one_allows_the_planner_to_schedule_a_cleanup() {
    let mut bench = Bench::new(vec![(activity(1), 0)]);
    bench.starts(1, min(0));
    let actions = bench.event(min(3), Event::Stop(id(1)));
    assert_eq!(aborted(&actions, 1), Some(Cause::Ordered));
    let wanted = actions
        .iter()
        .any(|action| matches!(action, Action::Replan(why) if why.contains(&Why::Outcome(id(1)))));
    assert!(wanted, "{actions:?}");
}

#[test]
fn nothing_starts_before_the_charge_has_recovered_from_the_hard_limit() {
    let mut bench = Bench::new(vec![(mandatory(1), 5)]);
    bench.estimate(min(1), 19, true);
    for (at, percent) in [(5, 19), (6, 39)] {
        bench.estimate(min(at), percent, true);
        assert_eq!(bench.control.waits_for(id(1)), Some(NotReady::Spent), "{percent} %");
    }
    bench.event(min(6), Event::Mode(Mode::Asleep));
    assert!(bench.estimate(min(7), 80, true).contains(&Action::Wake(Span::from_mins(5))));
    bench.event(min(12), Event::Mode(Mode::Awake));
    bench.starts(1, min(12));
}
