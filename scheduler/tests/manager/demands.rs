//! What a task needs beside its categories: draw, devices, memory, storage,
//! charge of the battery, places.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::manager::limits::SLOTS;
use faregate_scheduler::manager::{Event, Reading, Reply};
use faregate_scheduler::mission::{AgentSpec, BatterySpec, DeviceSpec};
use faregate_tickets::amount::Milliwatts;

use crate::world::{With, World, task};

fn watts(watts: u32) -> Milliwatts {
    Milliwatts::from_watts(watts)
}

fn device(name: &str, agent: &str, draw: u32) -> DeviceSpec {
    DeviceSpec {
        name: name.into(),
        kind: "simulated".into(),
        agent: agent.into(),
        draw: Some(watts(draw)),
        categories: Categories::NONE,
        parameters: BTreeMap::new(),
    }
}

fn powered() -> Mission {
    let agent = |name: &str, supply| AgentSpec { name: name.into(), supply: Some(watts(supply)) };
    Mission {
        agents: vec![agent("tasks", 42), agent("heaters", 10)],
        devices: vec![
            device("camera", "tasks", 10),
            device("gimbal", "tasks", 20),
            device("heater", "heaters", 6),
            device("oven", "heaters", 6),
        ],
        ..Mission::default()
    }
}

fn commands(id: u32, gates: &[&str]) -> faregate_scheduler::Task {
    task(id, 10.0).with(|task| task.gates = gates.iter().map(|gate| (*gate).into()).collect())
}

#[test]
fn as_many_run_as_the_supply_allows_by_importance() {
    let mut world = World::new(powered());
    let draws = [(1, 20, 1), (2, 20, 2), (3, 20, 3), (4, 2, 0)];
    world.add(draws.map(|(id, draw, priority)| {
        task(id, 10.0).priority(priority).with(|task| task.peak_draw = watts(draw))
    }));
    world.until(100.0);
    assert_eq!(
        world.lines(&["started", "waits"]),
        [
            "0.000 task 1 waits for draw: 18 W are missing",
            "0.000 task 3 attempt 1 started",
            "0.000 task 2 attempt 1 started",
            "0.000 task 4 attempt 1 started",
            "10.000 task 1 attempt 1 started",
        ]
    );
}

#[test]
fn victims_for_a_draw_are_the_least_important_and_no_more_than_it_takes() {
    let mut world = World::new(powered());
    let running = [(1, 10, 4), (2, 15, 3), (3, 12, 2), (4, 4, 1)];
    world.add(running.map(|(id, draw, priority)| {
        task(id, 60.0).priority(priority).with(|task| task.peak_draw = watts(draw))
    }));
    let taker = task(9, 5.0).priority(9).at(5.0);
    world.add([taker.with(|task| task.peak_draw = watts(13))]);
    world.until(20.0);
    // 42 W - 13 W leave 29 W: 10 + 15 + 4 fit, and 12 do not.
    assert_eq!(
        world.lines(&["paused", "resumed"]),
        ["5.000 task 3 attempt 1 paused", "10.000 task 3 attempt 1 resumed"]
    );
}

#[test]
fn each_device_draws_on_its_own_agent_and_has_one_user() {
    let mut world = World::new(powered());
    world.add([
        commands(1, &["camera", "heater"]).priority(9),
        commands(2, &["oven"]).priority(5),
        commands(3, &["camera"]).priority(4),
        commands(4, &["gimbal"]).priority(3).with(|task| task.peak_draw = watts(13)),
    ]);
    world.until(5.0);
    assert_eq!(
        world.lines(&["started", "waits"]),
        [
            "0.000 task 2 waits for draw: 2 W are missing",
            "0.000 task 3 waits for camera, which task 1 has",
            "0.000 task 4 waits for draw: 1 W are missing",
            "0.000 task 1 attempt 1 started",
        ]
    );
}

#[test]
fn one_that_needs_more_than_is_installed_never_runs_and_blocks_nobody() {
    let mission = Mission { memory: Some(100), storage: Some(100), ..powered() };
    let mut world = World::new(mission);
    world.add([
        task(1, 1.0).categories(1).priority(9).with(|task| task.peak_draw = watts(43)),
        task(2, 1.0).categories(1).priority(9).with(|task| task.memory = 101),
        task(3, 1.0).categories(1).priority(9).with(|task| task.storage = 102),
        task(4, 1.0).categories(1),
    ]);
    world.until(10.0);
    assert_eq!(
        world.lines(&["never", "started"]),
        [
            "0.000 task 1 never runs: it draws 1 W more than the supply",
            "0.000 task 2 never runs: it needs 1 bytes of memory more than there are",
            "0.000 task 3 never runs: it needs 2 bytes of storage more than there are",
            "0.000 task 4 attempt 1 started",
        ]
    );
    assert!(world.manager().is_over());
}

#[test]
fn memory_stays_reserved_while_a_task_is_paused_and_draw_does_not() {
    let mut world = World::new(Mission { memory: Some(100), ..powered() });
    let paused = task(1, 30.0).categories(1).with(|task| {
        task.memory = 60;
        task.peak_draw = watts(40);
    });
    let taker = task(2, 10.0).categories(1).priority(9).at(5.0);
    let hungry = task(3, 1.0).priority(5).at(6.0).with(|task| task.memory = 50);
    let modest = task(4, 1.0).priority(4).at(6.0).with(|task| {
        task.memory = 40;
        task.peak_draw = watts(42);
    });
    world.add([paused, taker, hungry, modest]);
    world.until(14.0);
    assert_eq!(
        world.lines(&["task 3", "task 4"]),
        [
            "6.000 task 3 waits for memory: 10 bytes are missing",
            "6.000 task 4 attempt 1 started",
            "7.000 task 4 attempt 1 succeeded (exit code 0)",
            "7.000 task 4 succeeded",
        ]
    );
    world.until(60.0);
    assert_eq!(
        world.lines(&["task 3 attempt 1 started", "task 1 succeeded", "task 1 attempt 1 resumed"]),
        [
            "15.000 task 1 attempt 1 resumed",
            "40.000 task 1 succeeded",
            "40.000 task 3 attempt 1 started"
        ]
    );
}

#[test]
fn measured_memory_counts_and_what_starts_is_taken_off_until_it_is_measured_again() {
    let mut world = World::new(Mission { memory: Some(1_000), ..Mission::default() });
    world.tell(Event::Reading(Reading::Memory(100)));
    world.add([1, 2].map(|id| task(id, 60.0).with(|task| task.memory = 60)));
    world.until(5.0);
    assert_eq!(
        world.lines(&["started", "waits"]),
        ["0.000 task 2 waits for memory: 20 bytes are missing", "0.000 task 1 attempt 1 started"]
    );
    world.tell(Event::Reading(Reading::Memory(70)));
    assert_eq!(world.lines(&["task 2 attempt 1 started"]).len(), 1);
}

#[test]
fn a_task_waits_for_the_battery_and_says_so_when_there_is_no_estimate() {
    let battery = Some(BatterySpec { low: 5 });
    let mut world = World::new(Mission { battery, ..Mission::default() });
    world.add([task(1, 10.0).with(|task| task.battery = 40)]);
    world.until(1.0);
    world.tell(Event::Reading(Reading::Battery(Some(39))));
    world.until(2.0);
    world.tell(Event::Reading(Reading::Battery(Some(40))));
    world.tell(Event::Reading(Reading::Battery(Some(20))));
    world.until(20.0);
    assert_eq!(
        world.lines(&["waits", "started", "paused"]),
        [
            "0.000 task 1 waits for the battery: no battery estimate",
            "2.000 task 1 attempt 1 started",
        ]
    );
    let mut without = World::new(Mission::default());
    let reply = without.try_add([task(1, 10.0).with(|task| task.battery = 40)]);
    assert!(matches!(reply, Reply::Refused(why) if why.contains("no battery")));
}

#[test]
fn no_more_run_than_there_are_places_and_the_most_important_has_one() {
    let many = u32::try_from(SLOTS).unwrap() + 5;
    let mut world = World::of((1..=many).map(|id| task(id, 60.0)));
    world.until(1.0);
    assert_eq!(world.lines(&["started"]).len(), SLOTS);
    world.add([task(999, 5.0).priority(1)]);
    world.until(2.0);
    assert_eq!(
        world.lines(&["paused", "task 999"]),
        ["1.000 task 40 attempt 1 paused", "1.000 task 999 attempt 1 started"]
    );
    world.until(200.0);
    assert!(world.manager().is_over(), "{:#?}", world.log.lines);
}
