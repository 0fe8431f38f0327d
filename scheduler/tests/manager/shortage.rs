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
