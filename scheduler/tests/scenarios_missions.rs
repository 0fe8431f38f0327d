//! What missions do with a schedule, on the virtual executive.

mod support;

use faregate_agents::Categories;
use faregate_scheduler::analyze::{Problem, ProblemKind};
use faregate_scheduler::mission::{AgentSpec, DeviceSpec, Mission, ModeSpec};
use faregate_scheduler::task::{Body, BuiltIn, CheckpointSignal, Preemption, Task, TaskPriority};
use faregate_tickets::amount::Milliwatts;

use support::{analysis, due, every, id, report, s, seconds, segments, task};

const IMAGING: u32 = 1;
const DOWNLINK: u32 = 2;

/// STP-H6: an image of low quality each minute. It and the downlink want the
/// same processor.
fn imaging_and_downlink(at: u64) -> [Task; 2] {
    [every(task(IMAGING, 20, 1, 1), 60), due(task(DOWNLINK, 20 * 60, 1, 5), at)]
}

#[test]
fn a_downlink_of_twenty_minutes_pauses_the_routine_image_and_lets_it_go_on() {
    let analysis = analysis(&imaging_and_downlink(130), &Mission::default(), 1_500);
    let image = segments(&analysis, IMAGING);
    assert_eq!(image[..3], [vec![(0, 20)], vec![(60, 80)], vec![(120, 130), (1_330, 1_340)]]);
    // Back in its phase, without a burst.
    assert_eq!(image[3..], [[(1_380, 1_400)], [(1_440, 1_460)]]);
    assert_eq!(seconds(report(&analysis, IMAGING).waited), 1_200);
}

#[test]
fn images_that_were_due_while_one_was_paused_are_one_problem() {
    let analysis = analysis(&imaging_and_downlink(130), &Mission::default(), 1_500);
    let missed: Vec<_> =
        analysis.problems.iter().filter(|one| one.kind == ProblemKind::Missed).collect();
    let [missed] = missed[..] else { panic!("{:?}", analysis.problems) };
    // 180, 240, ... 1320.
    assert_eq!(report(&analysis, IMAGING).more.misses.len(), 20);
    assert_eq!((missed.at, missed.every), (Some(s(180)), Some(s(60))));
    assert!(missed.message.contains("20 occurrences"), "{}", missed.message);
}

#[test]
fn a_window_that_closes_meanwhile_is_still_missed_at_the_horizon() {
    let mut tasks = imaging_and_downlink(90);
    tasks[0] = support::until(tasks[0].clone(), 5);
    // Nothing happens to the task after its misses: they are told all the same.
    let analysis = analysis(&tasks, &Mission::default(), 600);
    assert_eq!(report(&analysis, IMAGING).more.misses.len(), 8, "{:?}", analysis.problems);
}

/// All sensors off for a manoeuvre, and their processes: the routine camera is
/// paused, the radiometer is killed and run again, the magnetometer saves what
/// it has.
#[test]
fn a_manoeuvre_stops_every_sensor_and_its_task_and_then_they_go_on() {
    let mission = mission_with_sensors();
    let grace = s(2);
    let mut tasks = [task(1, 40, 0b1, 10), task(2, 30, 0b10, 10), task(3, 25, 0b100, 10)];
    for (task, gate) in tasks.iter_mut().zip(SENSORS) {
        task.gates = vec![gate.into()];
    }
    tasks[1].preemption = Preemption::Kill { grace };
    tasks[2].preemption = Preemption::Checkpoint { grace, signal: CheckpointSignal::default() };
    let enter = built_in(8, BuiltIn::EnterMode("manoeuvre".into()), 10);
    let leave = built_in(9, BuiltIn::LeaveMode("manoeuvre".into()), 60);
    let tasks = [tasks.to_vec(), vec![enter, leave]].concat();
    let analysis = analysis(&tasks, &mission, 200);
    assert_eq!(segments(&analysis, 1), [[(0, 10), (60, 90)]]);
    // From the start again.
    assert_eq!(segments(&analysis, 2), [[(0, 10)], [(60, 90)]]);
    // Its grace, and then what was left.
    assert_eq!(segments(&analysis, 3), [[(0, 12)], [(60, 75)]]);
    for number in [1, 2, 3] {
        let reason = report(&analysis, number).reason.clone().unwrap_or_default();
        assert!(reason.contains("mode manoeuvre"), "task {number}: {reason}");
    }
}

const SENSORS: [&str; 3] = ["camera", "radiometer", "magnetometer"];

fn mission_with_sensors() -> Mission {
    let devices = SENSORS.map(|name| DeviceSpec {
        name: name.into(),
        kind: "sensor".into(),
        agent: "bus".into(),
        draw: Some(Milliwatts::from_watts(5)),
        categories: Categories::NONE,
        parameters: std::collections::BTreeMap::default(),
    });
    let manoeuvre = ModeSpec {
        name: "manoeuvre".into(),
        reserves: SENSORS.map(String::from).to_vec(),
        ..ModeSpec::default()
    };
    let supply = Some(Milliwatts::from_watts(42));
    Mission {
        agents: vec![AgentSpec { name: "bus".into(), supply }],
        devices: devices.to_vec(),
        modes: vec![manoeuvre],
        ..Mission::default()
    }
}

fn built_in(number: u32, what: BuiltIn, at: u64) -> Task {
    let mut task = Task::new(id(number), Body::BuiltIn(what));
    task.priority = TaskPriority::TOP;
    due(task, at)
}

/// STP-H7: a limit of 42 W, and wishes for more.
#[test]
fn as_many_scripts_run_by_priority_as_the_supply_can_bear() {
    let mut tasks = [task(1, 10, 0, 5), task(2, 10, 0, 4), task(3, 10, 0, 3), task(4, 10, 0, 2)];
    for (task, watts) in tasks.iter_mut().zip([10, 20, 15, 12]) {
        task.peak_draw = Milliwatts::from_watts(watts);
    }
    let analysis = analysis(&tasks, &mission_with_sensors(), 100);
    // 10 + 20 leave no room for 15, but for 12.
    assert_eq!(support::starts(&analysis), [(0, 1), (0, 2), (0, 4), (10, 3)]);
    let [bus] = &analysis.utilisation.agents[..] else { panic!() };
    assert_eq!(bus.peak, Milliwatts::from_watts(42));
    assert_eq!(bus.wished.0, Milliwatts::from_watts(57));
    assert_eq!(bus.exceeded, Some(s(0)));
    let margins: Vec<_> = analysis
        .problems
        .iter()
        .filter(|problem| problem.kind == ProblemKind::Margin)
        .map(|problem| (problem.task, problem.at))
        .collect();
    assert_eq!(margins, [(None, Some(s(0))), (Some(id(3)), Some(s(0)))]);
    let reason = report(&analysis, 3).reason.as_deref();
    assert_eq!(reason, Some("waited for draw: 3 W are missing"));
}

#[test]
fn two_routine_tasks_that_meet_once_in_a_while_are_found_before_they_do() {
    let colliding = |begins| {
        let tasks = [every(task(1, 4, 1, 1), 50), due(every(task(2, 4, 1, 2), 70), begins)];
        let analysis = analysis(&tasks, &Mission::default(), 100);
        let collision = |problem: &Problem| problem.kind == ProblemKind::Collision;
        analysis.problems.into_iter().find(collision)
    };
    // Their dues differ by 25 and multiples of 10: never by less than 5.
    assert_eq!(colliding(25), None);
    // 33 + 70 is in 100 to 104, beyond the horizon.
    let collision = colliding(33).unwrap();
    assert_eq!((collision.task, collision.with), (Some(id(1)), Some(id(2))));
    assert_eq!((collision.at, collision.every), (Some(s(103)), Some(s(350))));
}
