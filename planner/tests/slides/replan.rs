//! Planning again: the commit window, what runs too long, cleanups, windows as
//! last queried.

use faregate_planner::plan::{Activity, Dependency, Kind, Outcome, Status};
use faregate_planner::schedule;
use faregate_planner::state::{Ended, Mode, Running, Window};
use faregate_planner::timed::{Fate, Slot, TimedPlan};
use faregate_planner::units::{Bytes, Span, Time};

use crate::rover::*;

fn running(timed: &TimedPlan, number: u32) -> Slot {
    let row = timed.rows.iter().find(|row| row.id == id(number)).unwrap();
    match row.fate {
        Fate::Running(slot) => slot,
        ref other => panic!("it does not run: {other:?}"),
    }
}

#[test]
fn what_runs_past_its_planned_end_is_expected_to_end_with_the_commit_window() {
    let ends = |minutes, commit| {
        let mut late = rover(vec![activity(1, 30, -60, -60)]);
        let (started, ends, cutoff) = (min(-60), min(minutes), min(400));
        let it = Running { id: id(1), started, ends, cutoff, paused: None, data: Bytes::ZERO };
        late.state.running = vec![it];
        late.state.mode = Mode::Awake;
        late.parameters.commit = commit;
        running(&late.timed(), 1).end
    };
    assert_eq!(ends(-5, Span::from_mins(10)), min(10));
    assert_eq!(ends(0, Span::from_mins(10)), min(10), "its end is now, and it runs");
    assert_eq!(ends(-5, Span::ZERO), Time::new(1_000), "a second at least");
    assert_eq!(ends(3, Span::from_mins(10)), min(3), "the control: it is not past it");
}

/// An activity has failed, and its cleanup and another one are there.
fn after_a_failure() -> Rover {
    let after = vec![Dependency { prior: id(1), statuses: vec![Status::Failed] }];
    let cleanup = Activity { kind: Kind::Cleanup, after, ..activity(2, 10, 0, 400) };
    let mut rover = rover(vec![activity(1, 30, -40, -40), cleanup, activity(3, 10, 0, 400)]);
    rover.state.mode = Mode::Awake;
    rover.state.ended = vec![Ended {
        id: id(1),
        outcome: Outcome::Failed,
        started: Some(min(-40)),
        ended: min(0),
        data: Bytes::ZERO,
    }];
    rover
}

#[test]
fn a_cleanup_starts_within_the_commit_window_and_nothing_else_that_is_new_does() {
    let rover = after_a_failure();
    let incumbent = TimedPlan::default();
    let timed = schedule(&rover.problem(), Some(&incumbent));
    assert_eq!(slot(&timed, 2), Some((0, 10)));
    assert_eq!(slot(&timed, 3), Some((10, 20)));
}

#[test]
fn windows_that_changed_are_planned_around_as_they_are_now() {
    let mut rover = rover(vec![drawing(100, activity(1, 30, 60, 200))]);
    let window = |from| Window {
        name: "pass".into(),
        start: min(from),
        end: min(from + 20),
        awake: true,
        marginal: load(100).marginal,
        peak: load(190).peak,
        data: Default::default(),
        engines: 0,
        resources: Default::default(),
    };
    rover.state.windows = vec![window(120)];
    let before = rover.timed();
    assert_eq!(slot(&before, 1), Some((60, 90)));
    rover.state.queried(vec![window(70)]);
    let timed = schedule(&rover.problem(), Some(&before));
    assert_eq!(slot(&timed, 1), Some((90, 120)), "it cannot run beside it");
    assert!(awake(&timed).iter().any(|it| it[1] <= 70 && 90 <= it[2]), "it is up for it");
}
