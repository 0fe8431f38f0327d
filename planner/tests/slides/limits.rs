//! "Constraining Parallelism", "Peak Power Check", "Limiting Data Storage
//! Usage", "Activity Time Ranges".

use faregate_agents::Categories;
use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::plan::{Activity, Effect, Impact, Kind, StartRange};
use faregate_planner::state::{Running, Window};
use faregate_planner::timed::{Excess, Limit, Reason};
use faregate_planner::units::{Bytes, Span};

use crate::rover::*;

#[test]
fn activities_with_a_common_resource_bit_are_not_in_parallel() {
    let with = |number, mask| Activity {
        resources: Categories::from_mask(mask),
        ..activity(number, 30, 60, 200)
    };
    let timed = rover(vec![with(1, 0b011), with(2, 0b110), with(3, 0b1000)]).timed();
    assert_eq!(slot(&timed, 1), Some((60, 90)));
    assert_eq!(slot(&timed, 2), Some((90, 120)));
    assert_eq!(slot(&timed, 3), Some((60, 90)));
}

#[test]
fn a_bit_that_is_held_from_now_to_the_end_is_held() {
    let bit = Categories::from_mask(1);
    let mut rover = rover(vec![
        Activity { resources: bit, ..activity(1, 1_500, 0, 0) },
        Activity { resources: bit, ..activity(2, 10, 0, 600) },
    ]);
    let (started, ends) = (min(0), min(1_500));
    let running =
        Running { id: id(1), started, ends, cutoff: ends, paused: None, data: Bytes::ZERO };
    rover.state.running = vec![running];
    rover.state.mode = faregate_planner::state::Mode::Awake;
    assert_eq!(limit(&rover.timed(), 2), Limit::Resources(1));
}

#[test]
fn the_sum_of_peaks_stays_below_the_threshold() {
    // With the computer's 70 W: 2 x 120 W are too much, 120 W and 110 W are not.
    let of = |watts| {
        let two =
            vec![drawing(120, activity(1, 30, 60, 200)), drawing(watts, activity(2, 30, 60, 200))];
        slot(&rover(two).timed(), 2)
    };
    assert_eq!(of(110), Some((60, 90)));
    assert_eq!(of(111), Some((90, 120)));
}

#[test]
fn no_more_sequence_engines_than_there_are() {
    let with = |number| Activity { engines: 1, ..activity(number, 30, 60, 200) };
    let timed = rover(vec![with(1), with(2), with(3)]).timed();
    assert_eq!(slot(&timed, 2), Some((60, 90)));
    assert_eq!(slot(&timed, 3), Some((90, 120)));
}

#[test]
fn optional_activities_keep_the_data_volume_and_mandatory_ones_need_not() {
    let with = |number, data, priority| Activity {
        data: Bytes::new(data),
        priority,
        ..activity(number, 30, 60, 200)
    };
    let must = rover(vec![with(1, 900, 10), with(2, 200, MANDATORY)]).timed();
    assert_eq!(limit(&must, 1), Limit::Data);
    let both = rover(vec![with(1, 900, MANDATORY), with(2, 200, MANDATORY)]).timed();
    assert_eq!((slot(&both, 2), both.excess[0].amount), (Some((60, 90)), 100));
    let optional = rover(vec![with(1, 900, 10), with(2, 101, 10), with(3, 100, 10)]).timed();
    assert_eq!(limit(&optional, 2), Limit::Data);
    assert_eq!(slot(&optional, 3), Some((60, 90)));
}

#[test]
fn an_activity_has_several_start_ranges_each_with_its_cutoff() {
    let range = |from, to, cutoff| StartRange { from: min(from), to: min(to), cutoff: min(cutoff) };
    let mut it = activity(1, 30, 0, 0);
    it.starts = vec![range(60, 90, 85), range(100, 110, 140)];
    let timed = rover(vec![it.clone()]).timed();
    assert_eq!(slot(&timed, 1), Some((100, 130)), "it would not be over by the first cutoff");
    assert_eq!(timed.slot(id(1)).unwrap().range, 1);
    it.starts.pop();
    assert_eq!(reason(&rover(vec![it]).timed(), 1), Reason::NoRangeLeft);
}

fn window(from: i64, to: i64, mask: u128) -> Window {
    Window {
        name: "pass".into(),
        start: min(from),
        end: min(to),
        awake: false,
        marginal: Default::default(),
        peak: Default::default(),
        data: Default::default(),
        engines: 0,
        resources: Categories::from_mask(mask),
    }
}

#[test]
fn what_windows_and_running_ones_hold_twice_is_unavoidable() {
    let bit = Categories::from_mask(0b110);
    let mut rover = rover(vec![
        Activity { resources: bit, ..activity(1, 100, 0, 0) },
        Activity { resources: bit, ..activity(2, 10, 0, 600) },
    ]);
    let (started, ends) = (min(0), min(100));
    let running =
        Running { id: id(1), started, ends, cutoff: ends, paused: None, data: Bytes::ZERO };
    rover.state.running = vec![running];
    rover.state.mode = faregate_planner::state::Mode::Awake;
    assert_eq!(rover.timed().unavoidable, []);
    rover.state.windows = vec![window(40, 60, 0b010)];
    let timed = rover.timed();
    let held =
        Excess { by: None, limit: Limit::Resources(0b010), at: min(40), amount: 20 * 60_000 };
    assert_eq!(timed.unavoidable, [held]);
    assert_eq!(slot(&timed, 2), Some((100, 110)));
}

#[test]
fn a_named_timeline_that_a_running_one_drains_is_unavoidable() {
    let rate = Impact { timeline: "fuel".into(), effect: Effect::Rate(-2) };
    let mut rover = rover(vec![Activity { impacts: vec![rate], ..activity(1, 10, 0, 0) }]);
    let name = "fuel".to_owned();
    let kind = TimelineKind::Consumable;
    rover.parameters.timelines = vec![TimelineSpec { name, kind, initial: 100, min: 0, max: 200 }];
    let (started, ends) = (min(0), min(10));
    let running =
        Running { id: id(1), started, ends, cutoff: ends, paused: None, data: Bytes::ZERO };
    rover.state.running = vec![running];
    rover.state.mode = faregate_planner::state::Mode::Awake;
    // Two a second: after 50 s there is none left, and a ms later too little.
    let at = faregate_planner::units::Time::new(50_001);
    let limit = Limit::Timeline("fuel".into());
    assert_eq!(rover.timed().unavoidable, [Excess { by: None, limit, at, amount: 1 }]);
}

/// The ground's shutdown and a window cannot both be had, and neither is the
/// planner's to move.
#[test]
fn a_window_in_a_manual_shutdown_is_unavoidable_and_all_else_is_planned() {
    let five = Span::from_mins(5);
    let kind = Kind::ManualShutdown { shutdown: five, wakeup: five };
    let night = Activity { kind, ..activity(1, 60, 60, 60) };
    let mut rover = rover(vec![night, activity(2, 20, 150, 200)]);
    let pass = |from, to, awake| Window { awake, ..window(from, to, 0) };
    rover.state.windows = vec![pass(110, 130, true), pass(70, 80, true), pass(75, 90, true)];
    let timed = rover.timed();
    let needed = Excess { by: None, limit: Limit::Computer, at: min(70), amount: 20 * 60_000 };
    assert_eq!(timed.unavoidable, [needed], "the first time, as long as it lasts");
    assert_eq!(slot(&timed, 2), Some((150, 170)));
    rover.state.windows = vec![pass(70, 90, false), pass(40, 60, true), pass(120, 130, true)];
    assert_eq!(rover.timed().unavoidable, [], "without the computer, before and after it");
}
