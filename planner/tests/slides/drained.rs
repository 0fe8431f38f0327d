//! "Predicting Future State of Charge", to the microjoule: a generator that gives
//! less than the base load, a battery that is full. And a zone that is found cold.

use faregate_planner::Activity;
use faregate_planner::plan::Outcome;
use faregate_planner::state::{Ended, Mode};
use faregate_planner::units::{Bytes, Ppm, Time};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::rover::*;

/// What a sleep will drain does not count before it is slept.
#[test]
fn no_sleep_begins_above_the_maximum_though_it_would_end_below_it() {
    let mut rover = rover(Vec::new());
    rover.parameters.rtg = Milliwatts::from_watts(10);
    rover.state.mode = Mode::Awake;
    rover.state.charge = watt_hours(950);
    // 50 Wh too much: 5 min of shutdown take 50 W, and before that the computer
    // takes 70 W. A sleep of 30 min would take 5 Wh.
    let too_much = 50 * 3_600_000_000_i64;
    let drained = too_much - 50_000 * 5 * 60_000;
    let down = drained.div_euclid(70_000) + 1;
    assert_ne!(drained.rem_euclid(70_000), 0, "it is rounded up");
    assert_eq!(rover.timed().awake[0].down, Time::new(down));
}

/// It would be a microjoule above its capacity when the computer is woken; an
/// hour later a microjoule is what there is too little.
#[test]
fn a_battery_holds_its_capacity_and_not_a_microjoule_more() {
    let (start, woken) = (min(60), min(55));
    // 80 W come in. The computer draws 60 W beside the activity, and 100 W in the
    // five minutes of its wakeup.
    let draws = 718_334;
    let drained = i64::from(draws + 60_000 - 80_000) * 3_600_000 + 20_000 * 300_000;
    let left_out = |less: u32| {
        let mut rover = rover(vec![activity(1, 60, 60, 60)]);
        rover.plan.activities[0].marginal = Milliwatts::new(u64::from(draws - less));
        rover.parameters.wakeup.load = load(100);
        rover.parameters.max_soc = Ppm::new(1_000_000);
        // What is above 30 % is a microjoule less than is drained.
        let capacity = ((drained - 1) * 10).div_euclid(7) + 1;
        assert_eq!((capacity * 7).div_euclid(10), drained - 1);
        let charge = capacity + 1 - 80_000 * woken.get();
        rover.state.capacity = Microjoules::new(capacity.unsigned_abs());
        rover.state.charge = Microjoules::new(charge.unsigned_abs());
        let timed = rover.timed();
        timed.slot(id(1)).is_none_or(|slot| slot.start != start)
    };
    assert!(left_out(0));
    assert!(!left_out(1), "with a milliwatt less it fits");
}

/// Heated again from scratch, as if nobody had been there.
#[test]
fn a_zone_that_was_found_cold_is_cold_though_it_was_used_just_now() {
    let arm =
        |number, from| Activity { zones: vec!["arm".into()], ..activity(number, 20, from, 90) };
    let mut rover = rover(vec![arm(1, -20), arm(2, 10)]);
    let (started, ended, outcome) = (Some(min(-20)), min(0), Outcome::Succeeded);
    rover.state.ended = vec![Ended { id: id(1), outcome, started, ended, data: Bytes::ZERO }];
    rover.state.mode = Mode::Awake;
    assert_eq!(slot(&rover.timed(), 2), Some((10, 30)), "it was left warm");
    rover.state.cold = vec!["arm".into()];
    let timed = rover.timed();
    assert_eq!(slot(&timed, 2), Some((20, 40)));
    assert_eq!((timed.preheats[0].start, timed.preheats[0].end), (min(0), min(20)));
}
