//! An activity has tickets for each thing that it uses, and none of them is
//! dispensable: whoever holds one of these things keeps it from starting.

use faregate_agents::Categories;
use faregate_planner::Activity;
use faregate_planner::units::{Span, Time};
use faregate_scheduler::task::Task;
use faregate_tickets::amount::Milliwatts;

use crate::small::{activity, bit, outside, small};
use crate::stage::{Fates, Stage, adding, clock, mission};

/// When it is planned to start.
const PLANNED: Time = clock(10, 10);
/// Somebody else holds something from before that on until after it.
const HELD: (Time, Time) = (clock(10, 5), clock(10, 40));

/// It commands a camera, holds the gas inlet and two of three engines, and draws
/// 300 W of the 340 W that the computer leaves.
fn hungry() -> Activity {
    Activity {
        sequence: Some("hazard_images".into()),
        resources: bit(4),
        engines: 2,
        peak: Milliwatts::from_watts(300),
        ..activity(1, 8, PLANNED)
    }
}

fn holding(change: impl FnOnce(Task) -> Task) -> Task {
    change(outside(HELD.0, 35))
}

fn gate(name: &str) -> Task {
    holding(|task| Task { gates: vec![name.into()], ..task })
}

fn categories(categories: Categories) -> Task {
    holding(|task| Task { categories, ..task })
}

fn engines(numbers: &[u32]) -> Task {
    let of = |number: &u32| bit(u32::from(mission().categories[&format!("engine {number}")]));
    categories(numbers.iter().map(of).fold(Categories::NONE, Categories::union))
}

fn draw(watts: u32) -> Task {
    holding(|task| Task { peak_draw: Milliwatts::from_watts(watts), ..task })
}

/// Executed until noon with somebody else there.
fn beside(activities: Vec<Activity>, other: Task) -> Stage {
    let mut stage = small(activities, Fates::new());
    stage.until(clock(10, 1));
    assert!(stage.director.timed().slot(crate::stage::id(1)).is_some(), "it is planned");
    stage.command(vec![adding(other)]);
    stage.until(clock(12, 0));
    assert_eq!(stage.refused(), [""; 0]);
    stage
}

#[test]
fn nothing_starts_while_another_holds_any_one_of_the_things_that_it_uses() {
    let held = [
        ("the gate that its sequence commands", gate("hazard_camera")),
        ("its resource", categories(bit(4))),
        ("two of the engines", engines(&[1, 3])),
        ("power", draw(41)),
    ];
    for (what, other) in held {
        let stage = beside(vec![hungry()], other);
        assert_eq!(stage.start_of(1), Some(HELD.1), "another one holds {what}");
    }
}

/// The control: what it does not use, others may have.
#[test]
fn what_it_does_not_use_another_may_hold() {
    let held = [
        ("another gate", gate("mast_camera")),
        ("another resource", categories(bit(2))),
        ("the engine that is left", engines(&[3])),
        ("the power that is left", draw(40)),
        ("nothing", holding(|task| task)),
    ];
    for (what, other) in held {
        let stage = beside(vec![hungry()], other);
        assert_eq!(stage.start_of(1), Some(PLANNED), "another one holds {what}");
    }
}

/// The mast is heated for 15 minutes for what begins after eleven.
fn warm(from: Time) -> Activity {
    Activity { zones: vec!["mast".into()], ..activity(1, 8, from) }
}

const FULLY: Span = Span::from_mins(15);

/// The zone is heated on tickets, and what needs it warm waits for that.
#[test]
fn nothing_is_heated_without_tickets_and_nothing_starts_that_was_not_heated_for() {
    let held = [("the heater", gate("heater_mast")), ("power", draw(301))];
    for (what, other) in held {
        let from = clock(11, 0);
        let other = Task { windows: crate::small::outside(clock(10, 40), 1).windows, ..other };
        let stage = beside(vec![warm(from)], other);
        let start = stage.start_of(1).unwrap_or_else(|| panic!("held: {what}"));
        let heated: Vec<_> = stage.starts_of_heating("mast");
        let last = heated.last().copied();
        assert_eq!(last.map(|last| start.since(last)), Some(FULLY), "{what}: {heated:?}");
        assert!(last >= Some(clock(11, 15)), "{what}: {heated:?}");
    }
    for (what, other) in [("another heater", gate("heater_arm")), ("less power", draw(300))] {
        let other = Task { windows: crate::small::outside(clock(10, 40), 1).windows, ..other };
        let stage = beside(vec![warm(clock(11, 0))], other);
        assert_eq!(stage.start_of(1), Some(clock(11, 0)), "{what}");
    }
}
