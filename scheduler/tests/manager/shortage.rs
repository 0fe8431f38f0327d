//! When memory or the battery runs low: the least important stop first.

use faregate_scheduler::Mission;
use faregate_scheduler::manager::{Event, Reading};
use faregate_scheduler::mission::BatterySpec;
use faregate_scheduler::task::Preemption;

use crate::world::{With, World, task};

#[test]
fn running_tasks_stop_least_important_first_until_it_is_clear_again() {
    let mission = Mission { memory_low: Some(50), ..Mission::default() };
    let mut world = World::new(mission);
    world.add([(1, 3), (2, 1), (3, 2)].map(|(id, priority)| task(id, 60.0).priority(priority)));
    let memory = |bytes| Event::Reading(Reading::Memory(bytes));
    world.until(1.0);
    world.tell(memory(49));
    world.until(2.0);
    world.tell(memory(30));
    world.until(3.0);
    world.add([task(4, 1.0).priority(9)]);
    world.until(4.0);
    world.tell(memory(50));
    world.until(5.0);
    assert_eq!(
        world.lines(&["paused", "resumed", "task 4 waits", "task 4 attempt 1 started"]),
        [
            "1.000 task 2 attempt 1 paused",
            "2.000 task 3 attempt 1 paused",
            "3.000 task 4 waits for memory: 20 bytes are missing",
            "4.000 task 4 attempt 1 started",
            "4.000 task 3 attempt 1 resumed",
            "4.000 task 2 attempt 1 resumed",
        ]
    );
}

#[test]
fn one_that_cannot_be_pre_empted_runs_on_when_the_battery_is_low() {
    let battery = Some(BatterySpec { low: 20 });
    let mut world = World::new(Mission { battery, ..Mission::default() });
    world.add([
        task(1, 60.0).with(|task| task.preemption = Preemption::Wait),
        task(2, 60.0).priority(5),
    ]);
    world.until(1.0);
    for percent in [19, 18, 17] {
        world.tell(Event::Reading(Reading::Battery(Some(percent))));
    }
    assert_eq!(
        world.lines(&["paused", "stopped", "waits"]),
        [
            "1.000 task 2 attempt 1 is being stopped: the battery: 20 % wanted, 19 % there",
            "1.000 task 2 attempt 1 paused",
            "1.000 task 2 waits for the battery: 20 % wanted, 19 % there",
        ]
    );
    world.tell(Event::Reading(Reading::Battery(Some(20))));
    assert_eq!(world.lines(&["resumed"]).len(), 1);
}

/// Who stands still for another reason would use what there is too little of.
#[test]
fn one_that_was_paused_before_does_not_go_on_while_there_is_a_shortage() {
    let battery = Some(BatterySpec { low: 20 });
    let mut world = World::new(Mission { battery, ..Mission::default() });
    let charge = |percent| Event::Reading(Reading::Battery(Some(percent)));
    world.add([
        task(1, 60.0).categories(1).priority(1),
        task(2, 60.0).categories(1).priority(2).at(1.0),
    ]);
    world.until(2.0);
    world.tell(charge(19));
    world.until(5.0);
    assert_eq!(
        world.lines(&["paused", "resumed"]),
        ["1.000 task 1 attempt 1 paused", "2.000 task 2 attempt 1 paused"]
    );
    world.tell(charge(20));
    assert_eq!(world.lines(&["resumed"]), ["5.000 task 2 attempt 1 resumed"]);
}

#[test]
fn a_shortage_is_over_when_that_was_measured_and_not_when_nothing_is_known() {
    let battery = Some(BatterySpec { low: 20 });
    let mut world = World::new(Mission { battery, ..Mission::default() });
    world.add([task(1, 60.0)]);
    world.until(1.0);
    world.tell(Event::Reading(Reading::Battery(Some(19))));
    world.until(2.0);
    world.tell(Event::Reading(Reading::Battery(None)));
    world.until(3.0);
    assert!(world.lines(&["resumed"]).is_empty());
    world.tell(Event::Reading(Reading::Battery(Some(20))));
    assert_eq!(world.lines(&["resumed"]), ["3.000 task 1 attempt 1 resumed"]);
}
