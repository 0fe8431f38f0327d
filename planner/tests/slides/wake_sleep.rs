//! "Wake/Sleep Scheduling with Energy Limits", "Activity Types: Shutdown
//! Related Activities".

use faregate_planner::plan::{Activity, Kind};
use faregate_planner::state::{Mode, Window};
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
