//! "Wake/Sleep Scheduling with Energy Limits", "Activity Types: Shutdown
//! Related Activities".

use faregate_planner::plan::{Activity, Kind, Outcome};
use faregate_planner::project;
use faregate_planner::state::{Ended, Mode, Window};
use faregate_planner::timed::Limit;
use faregate_planner::units::{Span, Time};

use crate::rover::*;

#[test]
fn a_wakeup_comes_before_an_activity_and_a_shutdown_after_it() {
    let timed = rover(vec![activity(1, 60, 120, 200)]).timed();
    assert_eq!(slot(&timed, 1), Some((120, 180)));
    assert_eq!(awake(&timed)[0], [115, 120, 180, 185]);
}

#[test]
fn an_awake_phase_lasts_at_least_the_minimum() {
    let timed = rover(vec![activity(1, 5, 120, 200)]).timed();
    assert_eq!(awake(&timed)[0], [115, 120, 130, 135]);
}

#[test]
fn a_sleep_shorter_than_the_minimum_is_not_slept() {
    let of = |from| rover(vec![activity(1, 30, 60, 60), activity(2, 30, from, from)]).timed();
    assert_eq!(awake(&of(129))[0], [55, 60, 159, 164]);
    assert_eq!(awake(&of(130))[..2], [[55, 60, 90, 95], [125, 130, 160, 165]]);
}

#[test]
fn no_sleep_goes_past_the_maximum_state_of_charge() {
    // 300 Wh at 80 W.
    let timed = rover(Vec::new()).timed();
    assert_eq!(timed.awake[0].wakeup, min(225));
    let mut higher = rover(Vec::new());
    higher.parameters.max_soc = faregate_planner::units::Ppm::new(1_000_000);
    assert_eq!(awake(&higher.timed()), Vec::<[i64; 4]>::new(), "a full battery may be slept with");
}

#[test]
fn nothing_starts_before_the_computer_can_be_up() {
    let timed = rover(vec![activity(1, 10, 0, 60), activity(2, 10, 0, 4)]).timed();
    assert_eq!(slot(&timed, 1), Some((5, 15)));
    assert_eq!(limit(&timed, 2), Limit::Lead);
}

#[test]
fn a_mode_in_progress_counts_its_elapsed_time() {
    let mut late = rover(vec![activity(1, 10, 0, 60)]);
    late.state.mode_since = min(-10);
    // Asleep for 10 min: the sleep lasts 20 more.
    assert_eq!(slot(&late.timed(), 1), Some((25, 35)));
    late.state.mode = Mode::Awake;
    assert_eq!(slot(&late.timed(), 1), Some((0, 10)));
    late.state.mode = Mode::WakingUp;
    late.state.mode_since = min(-3);
    assert_eq!(slot(&late.timed(), 1), Some((2, 12)));
}

#[test]
fn a_stay_awake_activity_keeps_the_computer_up() {
    let stay = Activity { kind: Kind::StayAwake, ..activity(1, 90, 60, 60) };
    assert_eq!(awake(&rover(vec![stay]).timed())[0], [55, 60, 150, 155]);
}

#[test]
fn nothing_overlaps_a_manual_shutdown_and_the_computer_is_up_around_it() {
    let five = Span::from_mins(5);
    let kind = Kind::ManualShutdown { shutdown: five, wakeup: five };
    let manual = Activity { kind, ..activity(1, 60, 60, 60) };
    let timed = rover(vec![manual, activity(2, 20, 50, 400), activity(3, 20, 70, 90)]).timed();
    assert_eq!(slot(&timed, 1), Some((60, 120)));
    assert_eq!(slot(&timed, 2), Some((120, 140)), "it does not fit before");
    assert_eq!(limit(&timed, 3), Limit::Computer);
    assert_eq!(awake(&timed)[..2], [[45, 50, 60, 60], [120, 120, 140, 145]]);
}

#[test]
fn a_manual_shutdown_that_was_vetoed_is_none() {
    let five = Span::from_mins(5);
    let kind = Kind::ManualShutdown { shutdown: five, wakeup: five };
    let manual = drawing(30, Activity { kind, ..activity(1, 60, 60, 60) });
    let within = activity(2, 20, 70, 90);
    let mut vetoed = rover(vec![manual, within.clone()]);
    let (outcome, data) = (Outcome::NotStarted, Default::default());
    vetoed.state.ended = vec![Ended { id: id(1), outcome, started: None, ended: min(0), data }];
    let without = rover(vec![within]);
    let seen = |rover: &Rover| {
        let timed = rover.timed();
        let Rover { plan, parameters, state } = rover;
        let lines = project(plan, parameters, state, &timed).unwrap().lines;
        (slot(&timed, 2), awake(&timed), lines)
    };
    assert_eq!(seen(&vetoed), seen(&without));
    assert_eq!(seen(&without).0, Some((70, 90)));
}

#[test]
fn a_communication_window_is_planned_around() {
    let window = |awake| Window {
        name: "pass".into(),
        start: min(60),
        end: min(80),
        awake,
        marginal: load(100).marginal,
        peak: load(190).peak,
        data: Default::default(),
        engines: 0,
        resources: Default::default(),
    };
    let mut busy = rover(vec![drawing(100, activity(1, 30, 50, 200))]);
    busy.state.windows = vec![window(true)];
    let timed = busy.timed();
    assert_eq!(slot(&timed, 1), Some((80, 110)), "their peaks are too much together");
    assert_eq!(awake(&timed)[0], [55, 60, 110, 115]);
    busy.plan.activities.clear();
    busy.state.windows = vec![window(false)];
    assert!(busy.timed().awake.iter().all(|phase| phase.wakeup > min(80)), "it needs no computer");
}

#[test]
fn the_last_sleep_may_be_cut_by_the_end() {
    let mut short = rover(vec![activity(1, 10, 60, 60)]);
    (short.plan.end, short.plan.handover) = (min(80), min(80));
    assert_eq!(awake(&short.timed()), vec![[55, 60, 70, 75]]);
    (short.plan.end, short.plan.handover) = (min(74), min(74));
    assert_eq!(awake(&short.timed()), vec![[55, 60, 74, 74]], "no time for a shutdown");
    assert_eq!(Time::ZERO, min(0));
}

#[test]
fn after_a_sleep_that_filled_the_battery_it_stays_up_until_another_one_fits_below_the_maximum() {
    let mut full = rover(Vec::new());
    full.parameters.awake = load(160);
    // Asleep until 900 Wh; 40 W while it wakes up, then -80 W; what the shutdown
    // and the shortest sleep bring, 43.3 Wh, must fit: after 35 minutes.
    let timed = full.timed();
    assert_eq!(awake(&timed)[0], [225, 230, 265, 270]);
    assert_eq!(awake(&timed)[1][0], 300, "and it sleeps no longer than that");
    full.parameters.min_sleep = Span::from_mins(15);
    assert_eq!(awake(&full.timed())[0], [225, 230, 250, 255], "15 min at 80 W fit sooner");
}

#[test]
fn a_phase_whose_end_is_blocked_begins_earlier() {
    let mut short = rover(vec![activity(1, 5, 75, 75)]);
    (short.plan.end, short.plan.handover) = (min(80), min(80));
    assert_eq!(awake(&short.timed()), vec![[65, 70, 80, 80]]);
}

#[test]
fn an_activity_beside_another_extends_the_phase_that_is_there() {
    let timed = rover(vec![activity(1, 30, 60, 60), activity(2, 30, 80, 80)]).timed();
    assert_eq!(awake(&timed)[0], [55, 60, 110, 115]);
}

#[test]
fn nothing_that_is_left_out_could_start_while_the_computer_sleeps() {
    let hungry = |number| drawing(160, activity(number, 60, 0, 300));
    let rover = rover((1..8).map(hungry).collect());
    let timed = rover.timed();
    let out = |number: &u32| timed.slot(id(*number)).is_none();
    let left_out: Vec<u32> = (1..8).filter(out).collect();
    assert!(!left_out.is_empty() && left_out.len() < 7, "{left_out:?}");
    let asleep = |at: &i64| !awake(&timed).iter().any(|it| it[0] <= *at && *at < it[3]);
    let minutes: Vec<i64> = (0..=300).filter(asleep).collect();
    assert!(minutes.len() > 20, "{minutes:?}");
    for number in left_out {
        for &at in &minutes {
            // All that is in stays where it is, and this one alone may start then.
            let mut tried = rover.clone();
            for activity in &mut tried.plan.activities {
                let slot = timed.slot(activity.id).map(|slot| slot.start);
                let start =
                    if activity.id == id(number) { min(at) } else { slot.unwrap_or(min(-1)) };
                (activity.starts[0].from, activity.starts[0].to) = (start, start);
                activity.priority = if activity.id == id(number) { 1 } else { 10 };
            }
            assert_eq!(tried.timed().slot(id(number)), None, "{number} at {at}");
        }
    }
}
