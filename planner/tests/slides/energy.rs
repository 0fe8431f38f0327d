//! "Predicting Future State of Charge", "Uses of State of Charge in
//! Scheduling".

use faregate_planner::timed::Limit;
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
