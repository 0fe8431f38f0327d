//! "Predicting Future State of Charge", "Uses of State of Charge in
//! Scheduling".

use faregate_planner::Activity;
use faregate_planner::project;
use faregate_planner::timed::{Limit, Reason};
use faregate_planner::units::{Ppm, Time};

use crate::rover::*;

/// 160 W for an hour: with the computer, 140 W more than comes in.
fn hungry(to: i64) -> Rover {
    let mut rover = rover(vec![drawing(160, activity(1, 60, 0, to))]);
    rover.state.charge = watt_hours(350);
    rover
}

#[test]
fn nothing_is_scheduled_that_would_go_below_the_soft_minimum() {
    // 350 Wh and 65 min at 80 W and 5 min at 40 W are 440 Wh; 300 Wh are left.
    assert_eq!(slot(&hungry(600).timed(), 1), Some((70, 130)));
    assert_eq!(limit(&hungry(69).timed(), 1), Limit::SoftMinimum);
    let mut lower = hungry(600);
    lower.state.charge =
        watt_hours(350).saturating_sub(faregate_tickets::amount::Microjoules::new(1));
    assert_eq!(lower.timed().slot(id(1)).unwrap().start, Time::new(70 * 60_000 + 1));
}

#[test]
fn mandatory_activities_keep_the_soft_minimum_too() {
    let mut rover = hungry(69);
    rover.plan.activities[0].priority = MANDATORY;
    assert_eq!(limit(&rover.timed(), 1), Limit::SoftMinimum);
}

#[test]
fn optional_activities_leave_the_minimum_at_handover_and_mandatory_ones_need_not() {
    let mut rover = rover(vec![drawing(160, activity(1, 60, 0, 100))]);
    rover.plan.handover = min(180);
    rover.plan.handover_min_soc = Ppm::new(800_000);
    let timed = rover.timed();
    assert_eq!(limit(&timed, 1), Limit::Handover);
    assert!(timed.excess.is_empty());
    rover.plan.activities[0].priority = MANDATORY;
    let timed = rover.timed();
    assert_eq!(slot(&timed, 1), Some((5, 65)));
    assert_eq!((timed.excess[0].by, timed.excess[0].at), (Some(id(1)), min(180)));
    assert_eq!(timed.excess[0].limit, Limit::Handover);
}

#[test]
fn what_base_load_breaks_by_itself_blocks_nothing_that_makes_it_no_worse() {
    let mut rover = rover(vec![drawing(10, activity(1, 10, 300, 300))]);
    rover.state.charge = watt_hours(100);
    let timed = rover.timed();
    assert_eq!(timed.unavoidable[0].limit, Limit::SoftMinimum);
    assert_eq!(slot(&timed, 1), Some((300, 310)), "by then the charge has recovered");
}

/// Of [from, to) in minutes, so many seconds lie before this instant.
fn seconds_of((from, to): (i64, i64), before: Time) -> i64 {
    (before.get().min(min(to).get()) - min(from).get()).max(0) / 1_000
}

#[test]
fn the_predicted_charge_is_the_present_one_less_base_load_and_the_sum_of_activities() {
    let rover = rover(vec![drawing(160, activity(1, 60, 60, 60))]);
    let timed = rover.timed();
    assert_eq!(awake(&timed)[0], [55, 60, 120, 125]);
    let Rover { plan, parameters, state } = &rover;
    let lines = project(plan, parameters, state, &timed).unwrap().lines;
    let charge = lines.iter().find(|line| line.name == "charge").unwrap();
    // Watts and minutes: waking up, awake, the activity, shutting down.
    let drawn = [(40, (55, 60)), (60, (60, 120)), (160, (60, 120)), (40, (120, 125))];
    let mut seen = 0;
    for &(at, value) in charge.points.iter().filter(|(at, _)| *at <= min(125)) {
        let used: i64 = drawn.iter().map(|(watts, over)| watts * seconds_of(*over, at)).sum();
        let base_and_recharge = (100 - 20) * at.get() / 1_000;
        let joules = 600 * 3_600 + base_and_recharge - used;
        assert_eq!(value, joules * 1_000_000, "at {at}");
        seen += 1;
    }
    assert!(seen >= 5, "at each change of what is drawn: {seen}");
}

#[test]
fn a_candidate_is_refused_for_what_it_leaves_to_what_comes_much_later() {
    // 310 Wh, 55 min at 80 W and 5 min at 40 W are 386.7 Wh, of which 37 min at
    // 140 W leave 300.3 Wh.
    let later = || Activity { priority: MANDATORY, ..drawing(160, activity(1, 37, 60, 60)) };
    let sooner = || drawing(10, activity(2, 10, 10, 10));
    let of = |activities| {
        let mut rover = rover(activities);
        rover.state.charge = watt_hours(310);
        rover.timed()
    };
    let timed = of(vec![later(), sooner()]);
    assert_eq!(slot(&timed, 1), Some((60, 97)));
    let Reason::Limit { limit, at, .. } = reason(&timed, 2) else { panic!("{timed:?}") };
    assert_eq!((limit, at), (Limit::SoftMinimum, min(97)), "as low as it gets");
    assert_eq!(slot(&of(vec![sooner()]), 2), Some((10, 20)), "the control: nothing comes later");
}

#[test]
fn what_a_mandatory_one_broke_at_handover_no_optional_one_makes_worse() {
    let must = Activity { priority: MANDATORY, ..drawing(160, activity(1, 60, 5, 5)) };
    let beside = |number, watts| drawing(watts, activity(number, 10, 20, 20));
    let mut rover = rover(vec![must, beside(2, 10), beside(3, 0)]);
    rover.plan.handover = min(180);
    rover.plan.handover_min_soc = Ppm::new(800_000);
    let timed = rover.timed();
    assert_eq!(timed.excess[0].limit, Limit::Handover);
    assert_eq!(limit(&timed, 2), Limit::Handover);
    assert_eq!(slot(&timed, 3), Some((20, 30)), "it draws nothing, and the computer is up");
}

#[test]
fn the_minimum_at_handover_admits_equality_and_counts_at_that_instant_alone() {
    let of = |handover, ppm| {
        let mut rover = rover(vec![drawing(160, activity(1, 60, 5, 5))]);
        rover.plan.handover = min(handover);
        rover.plan.handover_min_soc = Ppm::new(ppm);
        slot(&rover.timed(), 1).is_some()
    };
    // 600 Wh, 5 min at 40 W, 60 min at -140 W, 5 min at 40 W, 60 min at 80 W:
    // 546.6 Wh; and no more than 463.4 Wh at minute 65.
    assert_eq!([of(130, 546_666), of(130, 546_667)], [true, false]);
    assert_eq!([of(65, 463_333), of(65, 463_334)], [true, false]);
}
