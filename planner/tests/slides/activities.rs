//! "Activity Types", "Activity Attributes": dependencies, groups, expanding
//! activities, cleanup, preheating; the commit window.

use faregate_planner::plan::{Activity, Dependency, Kind, Outcome, Status};
use faregate_planner::schedule;
use faregate_planner::state::Ended;
use faregate_planner::timed::{Limit, Reason, TimedPlan};
use faregate_planner::units::{Bytes, Ppm, Span, Time};

use crate::rover::*;

fn after(prior: u32, status: Status, activity: Activity) -> Activity {
    let after = vec![Dependency { prior: id(prior), statuses: vec![status] }];
    Activity { after, ..activity }
}

#[test]
fn a_dependant_starts_when_its_prior_has_succeeded() {
    let next = after(1, Status::Succeeded, activity(2, 10, 0, 400));
    let timed = rover(vec![activity(1, 30, 60, 60), next]).timed();
    assert_eq!(slot(&timed, 2), Some((90, 100)));
}

#[test]
fn a_dependant_of_one_that_is_left_out_is_left_out() {
    let next = after(1, Status::Succeeded, activity(2, 10, 0, 400));
    let timed = rover(vec![activity(1, 30, 0, 0), next]).timed();
    assert_eq!(limit(&timed, 1), Limit::Lead);
    assert_eq!(reason(&timed, 2), Reason::PriorOut(id(1)));
}

#[test]
fn a_cleanup_waits_for_an_outcome_and_runs_after_a_failure() {
    let cleanup = Activity { kind: Kind::Cleanup, ..activity(2, 10, 0, 400) };
    let mut rover = rover(vec![activity(1, 30, 60, 60), after(1, Status::Failed, cleanup)]);
    assert_eq!(reason(&rover.timed(), 2), Reason::WaitsForOutcome(id(1)));
    let ended = |outcome| Ended {
        id: id(1),
        outcome,
        started: Some(min(-40)),
        ended: min(-10),
        data: Bytes::ZERO,
    };
    rover.state.ended = vec![ended(Outcome::Failed)];
    assert_eq!(slot(&rover.timed(), 2), Some((5, 15)));
    rover.state.ended = vec![ended(Outcome::Succeeded)];
    assert_eq!(reason(&rover.timed(), 2), Reason::PriorEnded(id(1), Outcome::Succeeded));
}

#[test]
fn of_a_group_one_is_selected_and_the_cheaper_one_if_the_best_does_not_fit() {
    let member = |it: Activity| Activity { group: Some("image".into()), ..it };
    let best = |watts| member(Activity { priority: 20, ..drawing(watts, activity(1, 30, 60, 90)) });
    let cheap = || member(activity(2, 10, 60, 90));
    let timed = rover(vec![best(10), cheap()]).timed();
    assert_eq!(reason(&timed, 2), Reason::GroupTaken(id(1)));
    let timed = rover(vec![best(400), cheap()]).timed();
    assert_eq!((limit(&timed, 1), slot(&timed, 2)), (Limit::Peak, Some((60, 70))));
}

#[test]
fn an_expanding_activity_runs_as_long_as_limits_let_it() {
    let drive = |longest| Activity {
        kind: Kind::Expanding { minimum: Span::from_mins(30) },
        duration: Span::from_mins(longest),
        ..drawing(160, activity(1, 30, 60, 60))
    };
    assert_eq!(slot(&rover(vec![drive(90)]).timed(), 1), Some((60, 150)));
    // 600 Wh, 55 min at 80 W, 5 min at 40 W; then 140 W until 300 Wh are left.
    let timed = rover(vec![drive(600)]).timed();
    let left = (300.0 + 80.0 * 55.0 / 60.0 + 40.0 * 5.0 / 60.0) / 140.0 * 3_600_000.0_f64;
    let ran = timed.slot(id(1)).unwrap().length().get();
    assert!((ran as f64 - left).abs() <= 1.0, "{ran} and not {left}");
    let mut cut = drive(600);
    cut.starts[0].cutoff = min(100);
    assert_eq!(slot(&rover(vec![cut]).timed(), 1), Some((60, 100)));
}

/// Only the minimum of a mandatory one is mandatory.
#[test]
fn a_mandatory_drive_is_made_no_longer_than_the_handover_minimum_allows() {
    let of = |ppm| {
        let kind = Kind::Expanding { minimum: Span::from_mins(30) };
        let duration = Span::from_mins(600);
        let drive = Activity { kind, duration, priority: MANDATORY, ..activity(1, 30, 60, 60) };
        let mut rover = rover(vec![drawing(160, drive)]);
        rover.parameters.max_soc = Ppm::new(1_000_000);
        rover.plan.handover = min(300);
        rover.plan.handover_min_soc = Ppm::new(ppm);
        rover.timed()
    };
    // 676.7 Wh at minute 60; what ends at minute e leaves 1213.3 Wh - e * 220/60
    // at minute 300: 800 Wh, if that is minute 112.7.
    let end = |timed: &TimedPlan| timed.slot(id(1)).map(|slot| slot.end);
    assert_eq!(end(&of(800_000)), Some(Time::new(6_763_636)));
    let broken = of(900_000);
    assert_eq!(end(&broken), Some(min(90)), "its minimum breaks it, and it gets no more");
    assert_eq!(broken.excess[0].limit, Limit::Handover);
}

#[test]
fn a_zone_is_heated_before_its_use_for_as_long_as_the_time_of_day_asks() {
    let of = |from| {
        let arm = Activity { zones: vec!["arm".into()], ..activity(1, 30, from, from) };
        let mut rover = rover(vec![arm]);
        // So little that no sleep before it ends at the maximum.
        rover.state.charge = watt_hours(50);
        rover.parameters.soft_min_soc = Ppm::new(0);
        let timed = rover.timed();
        let heat = timed.preheats[0].clone();
        let up = awake(&timed).into_iter().find(|it| it[2] > from).unwrap()[1];
        (heat.start, heat.end, up)
    };
    assert_eq!(of(100), (min(80), min(100), 80));
    assert_eq!(of(600), (min(590), min(600), 590));
}

#[test]
fn a_zone_that_a_use_left_warm_is_heated_from_there_on() {
    let arm =
        |number, from| Activity { zones: vec!["arm".into()], ..activity(number, 30, from, from) };
    let timed = rover(vec![arm(1, 100), arm(2, 140), arm(3, 150)]).timed();
    let heats: Vec<_> = timed.preheats.iter().map(|heat| (heat.start, heat.end)).collect();
    assert_eq!(heats, [(min(80), min(100)), (min(130), min(140))]);
}

#[test]
fn what_starts_within_the_commit_window_is_left_alone() {
    let mut rover = rover(vec![activity(1, 10, 5, 60)]);
    let incumbent = rover.timed();
    assert_eq!(slot(&incumbent, 1), Some((5, 15)));
    let important = Activity { priority: 50, ..activity(2, 10, 0, 9) };
    rover.plan.activities.push(important);
    rover.plan.activities.push(activity(3, 10, 0, 60));
    let timed = schedule(&rover.problem(), Some(&incumbent));
    assert_eq!(slot(&timed, 1), Some((5, 15)));
    assert_eq!(reason(&timed, 2), Reason::Committed);
    assert_eq!(slot(&timed, 3), Some((10, 20)));
}

#[test]
fn equal_input_gives_an_equal_plan() {
    let all = || rover((1..20).map(|n| drawing(n * 7, activity(n, 20, 0, 900))).collect()).timed();
    assert_eq!(all(), all());
}
