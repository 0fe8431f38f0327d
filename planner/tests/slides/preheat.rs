//! "Preheating": "Preheat activities are not uplinked as part of the plan", and
//! they are planned together with what needs them.

use faregate_planner::parameters::{PreheatRow, Zone};
use faregate_planner::plan::{Activity, Outcome, StartRange};
use faregate_planner::state::{Ended, Mode};
use faregate_planner::timed::{Limit, TimedPlan};
use faregate_planner::units::{Bytes, Span, Time};
use faregate_tickets::amount::Milliwatts;

use crate::rover::*;

fn arm(number: u32, minutes: i64, from: i64, to: i64) -> Activity {
    Activity { zones: vec!["arm".into()], ..activity(number, minutes, from, to) }
}

/// Zone, begin and end in minutes.
fn heats(timed: &TimedPlan) -> Vec<(&str, i64, i64)> {
    let all = timed.preheats.iter();
    all.map(|it| (it.zone.as_str(), it.start.get() / 60_000, it.end.get() / 60_000)).collect()
}

#[test]
fn an_activity_and_its_preheat_are_looked_for_together() {
    // Beside 70 W of the computer and 210 W there is no room for a heater's 30 W.
    let strong = || Activity { priority: 20, ..drawing(210, activity(1, 30, 60, 60)) };
    let timed = rover(vec![strong(), arm(2, 30, 61, 200)]).timed();
    assert_eq!(
        slot(&timed, 2),
        Some((110, 140)),
        "it fits from minute 61 on, its heating does not"
    );
    assert_eq!(heats(&timed), [("arm", 90, 110)]);
    let without = rover(vec![strong(), activity(2, 30, 61, 200)]).timed();
    assert_eq!(slot(&without, 2), Some((61, 91)), "the control: it needs no heating");
}

#[test]
fn what_shares_a_zone_is_heated_for_and_paid_for_once() {
    let two = |limit| {
        let mut rover = rover(vec![arm(1, 30, 100, 100), arm(2, 30, 100, 100)]);
        rover.parameters.peak_limit = Milliwatts::from_watts(limit);
        rover.timed()
    };
    // The computer's 70 W and one heater's 30 W.
    let timed = two(100);
    assert_eq!(heats(&timed), [("arm", 80, 100)]);
    assert_eq!([slot(&timed, 1), slot(&timed, 2)], [Some((100, 130)); 2]);
    assert_eq!(limit(&two(99), 1), Limit::Peak, "a heater's peak is in the sum");
}

#[test]
fn zones_are_heated_at_the_same_time_each_for_its_own() {
    let zones = vec!["arm".into(), "mast".into()];
    let mut rover = rover(vec![Activity { zones, ..activity(1, 30, 100, 100) }]);
    let table = vec![PreheatRow { from: Span::ZERO, duration: Span::from_mins(35) }];
    rover.parameters.zones.push(Zone { name: "mast".into(), load: load(20), table });
    assert_eq!(heats(&rover.timed()), [("mast", 65, 100), ("arm", 80, 100)]);
    rover.parameters.peak_limit = Milliwatts::from_watts(129);
    assert_eq!(limit(&rover.timed(), 1), Limit::Peak, "both draw from minute 80 on");
}

#[test]
fn a_row_of_the_table_holds_from_its_time_of_day_to_the_millisecond_before_the_next() {
    let heated = |ms: i64| {
        let mut arm = arm(1, 30, 0, 0);
        let start = Time::new(min(600).get() + ms);
        arm.starts = vec![StartRange { from: start, to: start, cutoff: min(1_000) }];
        let timed = rover(vec![arm]).timed();
        timed.preheats[0].end.since(timed.preheats[0].start)
    };
    assert_eq!(heated(-1), Span::from_mins(20));
    assert_eq!(heated(0), Span::from_mins(10));
}

#[test]
fn heating_in_progress_counts_from_its_begin() {
    let since = |minutes| {
        let mut rover = rover(vec![arm(1, 30, 5, 5)]);
        rover.state.mode = Mode::Awake;
        rover.state.heating.insert("arm".into(), min(minutes));
        rover.timed()
    };
    let timed = since(-15);
    assert_eq!((slot(&timed, 1), heats(&timed)), (Some((5, 35)), vec![("arm", 0, 5)]));
    assert_eq!(limit(&since(-14), 1), Limit::Lead, "a minute too short");
}

#[test]
fn what_an_ended_use_left_warm_is_heated_from_there_on_unless_it_was_found_cold() {
    let used = Ended {
        id: id(1),
        outcome: Outcome::Succeeded,
        started: Some(min(-30)),
        ended: min(0),
        data: Bytes::ZERO,
    };
    let mut rover = rover(vec![arm(1, 30, -30, -30), arm(2, 30, 12, 12)]);
    rover.state.mode = Mode::Awake;
    rover.state.ended = vec![used];
    assert_eq!(heats(&rover.timed()), [("arm", 0, 12)]);
    rover.state.cold = vec!["arm".into()];
    assert_eq!(limit(&rover.timed(), 2), Limit::Lead, "from scratch it takes 20 minutes");
}
