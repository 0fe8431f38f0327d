//! "Predicting Future State of Charge", where the generator gives less than the
//! base load: also asleep the battery is drained.

use faregate_planner::state::Mode;
use faregate_planner::units::Time;
use faregate_tickets::amount::Milliwatts;

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
