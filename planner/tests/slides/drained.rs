//! "Predicting Future State of Charge", to the microjoule: a generator that gives
//! less than the base load, a battery that is full, a maximum that is no whole
//! number, a drain that goes on over the handover. And a zone that is found cold, and what
//! a running activity holds.

use faregate_planner::Activity;
use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::plan::{Effect, Impact, Kind, Outcome};
use faregate_planner::state::{Ended, Mode, Running};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
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

/// A fraction of the capacity that is no whole number of microjoules: the
/// maximum is not above it.
#[test]
fn a_maximum_is_rounded_down() {
    let mut rover = rover(Vec::new());
    let whole = 3_600_000_000_000;
    rover.state.capacity = Microjoules::new(whole + 1);
    // Asleep it gains 80 W. At this instant it would be a microjoule above nine
    // tenths of that whole.
    let full = min(225);
    let charge = whole / 10 * 9 + 1 - 80_000 * full.get().unsigned_abs();
    rover.state.charge = Microjoules::new(charge);
    assert_eq!(rover.timed().awake[0].wakeup, full.before(Span::new(1)));
    rover.state.charge = Microjoules::new(charge - 1);
    assert_eq!(rover.timed().awake[0].wakeup, full);
}

/// All of it drains a microjoule too much before the handover. Where it ends a
/// millisecond after that, a millisecond of it is drained later.
#[test]
fn what_is_drained_after_the_handover_is_not_missing_then() {
    let (hour, handover) = (Span::from_mins(60), min(300));
    let stay = Activity { kind: Kind::StayAwake, ..activity(2, 600, 0, 0) };
    let mut rover = rover(vec![drawing(160, activity(1, 60, 0, 500)), stay]);
    rover.plan.activities[1].priority = MANDATORY;
    rover.plan.handover = handover;
    rover.plan.handover_min_soc = Ppm::new(500_000);
    // Awake it gains 20 W.
    let needed = 1_800_000_000_000 - 20_000 * handover.get() + 160_000 * hour.get();
    let starts = |charge: i64| {
        rover.state.charge = Microjoules::new(charge.unsigned_abs());
        rover.state.mode = Mode::Awake;
        rover.timed().slot(id(1)).map(|slot| slot.start)
    };
    let [enough, less] = [needed, needed - 1].map(starts);
    assert_eq!(enough, Some(min(0)));
    assert_eq!(less, Some(handover.before(hour).after(Span::new(1))));
}

/// What the state says of a timeline has in it what a running one holds.
#[test]
fn what_a_running_one_holds_is_held_once() {
    let holds = |number, amount| {
        let impacts = vec![Impact { timeline: "bus".into(), effect: Effect::Hold(amount) }];
        Activity { impacts, ..activity(number, 100, 0, 90) }
    };
    let fits = |amount| {
        let mut rover = rover(vec![holds(1, 2), holds(2, amount)]);
        let (name, kind) = ("bus".to_owned(), TimelineKind::Renewable);
        rover.parameters.timelines = vec![TimelineSpec { name, kind, initial: 0, min: 0, max: 3 }];
        rover.state.timelines.insert("bus".into(), 2);
        let (started, ends) = (min(0), min(100));
        let running =
            Running { id: id(1), started, ends, cutoff: ends, paused: None, data: Bytes::ZERO };
        rover.state.running = vec![running];
        rover.state.mode = Mode::Awake;
        slot(&rover.timed(), 2).is_some()
    };
    assert_eq!([fits(1), fits(2)], [true, false]);
}
