//! What a running manager can be told.

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::journal::replay;
use faregate_scheduler::manager::limits::MOST_ENDED;
use faregate_scheduler::manager::{Record, Reply, State, Telecommand};
use faregate_scheduler::mission::{DeviceSpec, ModeSpec};
use faregate_scheduler::task::{
    Body, BuiltIn, Dependency, Outcome, Preemption, Status, Task, TaskPriority,
};

use crate::world::{SLOW, With, World, id, task, wall};

fn refused(reply: Reply) -> String {
    match reply {
        Reply::Refused(why) => why,
        Reply::Done => panic!("it was done"),
    }
}

fn built_in(number: u32, what: BuiltIn) -> Task {
    Task::new(id(number), Body::BuiltIn(what))
}

#[test]
fn an_id_in_use_is_refused_and_that_of_an_ended_task_may_be_used_again() {
    let mut world = World::of([task(1, 5.0)]);
    assert_eq!(refused(world.try_add([task(2, 1.0), task(1, 1.0)])), "task 1: its id is in use");
    world.until(10.0);
    world.add([task(1, 2.0)]);
    world.until(20.0);
    assert_eq!(world.lines(&["task 1 succeeded"]).len(), 2);
    let loads = world.journal.records.iter().filter_map(|record| match record {
        Record::Accepted { load, .. } => Some(*load),
        _ => None,
    });
    assert_eq!(loads.collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn every_defect_of_a_load_is_named_and_nothing_is_loaded() {
    let broken = [
        task(1, 1.0).with(|task| task.windows.clear()),
        task(2, 1.0).every(0.0),
        task(3, 1.0).with(|task| task.gates = vec!["camera".into()]),
        task(4, 1.0).with(|task| task.cleanup = Some(id(99))),
        task(5, 1.0),
        task(5, 1.0),
        built_in(6, BuiltIn::EnterMode("quiet".into())),
        task(7, 1.0).with(|task| {
            task.body = Body::Function { number: 16, arguments: vec![] };
        }),
    ];
    let mut world = World::of([]);
    let why = refused(world.try_add(broken));
    let defects: Vec<_> = why.split("; ").collect();
    assert_eq!(
        defects,
        [
            "task 5: its id is there twice",
            "task 1: it has no window",
            "task 2: its interval is zero: give none, or a longer one",
            "task 3: the mission has no device camera",
            "task 4: task 99 is to clean up, and is not in the schedule",
            "task 6: the mission has no mode quiet",
            "task 7: a function can only wait or be checkpointed",
        ]
    );
    assert_eq!(world.manager().status().count(), 0);
    assert!(world.journal.records.is_empty());
}

#[test]
fn a_removed_task_is_gone_and_one_that_runs_is_aborted() {
    let mut world = World::of([task(1, 50.0).categories(1), task(2, 5.0).categories(1)]);
    world.until(1.0);
    assert_eq!(world.ask(Telecommand::Remove(vec![id(1)])), Reply::Done);
    world.until(10.0);
    assert_eq!(
        world.lines(&["task 1 aborted", "1 removed", "started"]),
        [
            "0.000 task 1 attempt 1 started",
            "1.000 task 1 aborted",
            "1.000 task 1 removed",
            "1.000 task 2 attempt 1 started",
        ]
    );
    assert!(refused(world.ask(Telecommand::Remove(vec![id(1)]))).contains("not in the schedule"));
    assert!(world.manager().task(id(1)).is_none());
}

#[test]
fn a_task_that_is_over_is_removed_too() {
    let mut world = World::of([task(1, 5.0), task(2, 50.0)]);
    world.until(10.0);
    assert!(world.manager().task(id(1)).is_some(), "the control is lost: it is gone already");
    assert_eq!(world.ask(Telecommand::Remove(vec![id(1)])), Reply::Done);
    world.until(11.0);
    assert!(world.manager().task(id(1)).is_none());
    assert!(refused(world.ask(Telecommand::Remove(vec![id(1)]))).contains("not in the schedule"));
    assert_eq!(world.manager().status().count(), 1);
}

#[test]
fn a_new_priority_counts_at_once() {
    let mut world = World::of([
        task(1, 50.0).categories(1).priority(5),
        task(2, 5.0).categories(1).priority(3),
        task(3, 5.0).categories(1).priority(4),
    ]);
    world.until(1.0);
    world.ask(Telecommand::SetPriority(id(2), TaskPriority::new(9).unwrap()));
    assert_eq!(
        world.lines(&["paused", "task 2 attempt 1 started"]),
        ["1.000 task 1 attempt 1 paused", "1.000 task 2 attempt 1 started"]
    );
    world.ask(Telecommand::SetPriority(id(1), TaskPriority::new(1).unwrap()));
    world.until(6.5);
    assert_eq!(world.lines(&["task 3 attempt 1 started"])[0], "6.000 task 3 attempt 1 started");
}

#[test]
fn a_new_window_counts_at_once() {
    let mut world = World::of([task(1, 5.0).at(100.0)]);
    world.until(1.0);
    let windows = task(9, 1.0).at(3.0).windows;
    world.ask(Telecommand::SetWindows(id(1), windows));
    world.until(10.0);
    assert_eq!(world.lines(&["started"]), ["3.000 task 1 attempt 1 started"]);
}

#[test]
fn a_held_task_does_not_start_and_one_that_runs_is_pre_empted_until_it_is_let_go() {
    let mut world = World::of([task(1, 10.0), task(2, 5.0).at(3.0)]);
    world.until(2.0);
    for number in [1, 2] {
        assert_eq!(world.ask(Telecommand::Hold(id(number))), Reply::Done);
    }
    world.until(5.0);
    for number in [1, 2] {
        assert_eq!(world.ask(Telecommand::Resume(id(number))), Reply::Done);
    }
    world.until(60.0);
    assert_eq!(
        world.lines(&["paused", "resumed", "started", "succeeded ("]),
        [
            "0.000 task 1 attempt 1 started",
            "2.000 task 1 attempt 1 paused",
            "5.000 task 1 attempt 1 resumed",
            "5.000 task 2 attempt 1 started",
            "10.000 task 2 attempt 1 succeeded (exit code 0)",
            "13.000 task 1 attempt 1 succeeded (exit code 0)",
        ]
    );
    assert!(refused(world.ask(Telecommand::Resume(id(9)))).contains("not in the schedule"));
}

#[test]
fn clear_drops_what_is_pending_and_clear_all_what_runs_too() {
    for all in [false, true] {
        let routine = task(1, 10.0).every(20.0);
        let mut world = World::of([routine, task(2, 10.0), task(3, 1.0).at(50.0)]);
        world.until(1.0);
        assert_eq!(world.ask(Telecommand::Clear { all }), Reply::Done);
        world.until(100.0);
        assert_eq!(world.lines(&["task 2 succeeded"]).len(), usize::from(!all));
        assert_eq!(world.lines(&["task 2 aborted"]).len(), usize::from(all));
        assert_eq!(world.lines(&["started"]).len(), 2);
        assert!(world.manager().is_over());
    }
}

fn moded() -> Mission {
    let mode = |name: &str| ModeSpec { name: name.into(), ..ModeSpec::default() };
    let camera = DeviceSpec {
        name: "camera".into(),
        kind: String::new(),
        agent: "tasks".into(),
        draw: None,
        categories: Categories::NONE,
        parameters: Default::default(),
    };
    Mission {
        devices: vec![camera],
        modes: vec![
            ModeSpec { floor: TaskPriority::new(5).unwrap(), ..mode("urgent") },
            ModeSpec { blocks: Categories::from_mask(1), ..mode("quiet") },
            ModeSpec { reserves: vec!["camera".into()], ..mode("manoeuvre") },
        ],
        ..Mission::default()
    }
}

#[test]
fn while_a_mode_lasts_what_it_forbids_does_not_run() {
    for (mode, stops) in [("urgent", [1, 3]), ("quiet", [1, 1]), ("manoeuvre", [3, 3])] {
        let mut world = World::new(moded());
        let commands = |task: &mut Task| task.gates = vec!["camera".into()];
        world.add([
            task(1, 20.0).categories(1),
            task(2, 20.0).categories(2).priority(7),
            task(3, 20.0).with(commands),
        ]);
        world.until(1.0);
        assert_eq!(world.ask(Telecommand::EnterMode(mode.into())), Reply::Done);
        world.until(5.0);
        let mut stopped: Vec<_> = [1, 2, 3]
            .into_iter()
            .filter(|n| !world.lines(&[&format!("task {n} attempt 1 paused")]).is_empty())
            .collect();
        stopped.dedup();
        let mut expected = stops.to_vec();
        expected.dedup();
        assert_eq!(stopped, expected, "{mode}: {:#?}", world.log.lines);
        // In the same words, whoever took the tickets: the manager or an agent.
        let stopping = format!("is being stopped: mode {mode}");
        assert_eq!(world.lines(&["is being stopped"]), world.lines(&[&stopping]));
        assert_eq!(world.ask(Telecommand::LeaveMode(mode.into())), Reply::Done);
        world.until(60.0);
        assert!(world.manager().is_over(), "{mode}: {:#?}", world.log.lines);
        assert_eq!(world.lines(&["resumed"]).len(), expected.len());
    }
}

#[test]
fn a_mode_ends_even_one_that_cannot_be_pre_empted() {
    let mut world = World::new(moded());
    let waits = task(1, 20.0).categories(1).with(|task| task.preemption = Preemption::Wait);
    world.add([waits]);
    world.until(1.0);
    world.ask(Telecommand::EnterMode("quiet".into()));
    assert_eq!(world.lines(&["pre-empted"]).len(), 1, "{:#?}", world.log.lines);
    assert!(refused(world.ask(Telecommand::EnterMode("none".into()))).contains("no mode"));
    assert!(refused(world.ask(Telecommand::LeaveMode("urgent".into()))).contains("not entered"));
}

#[test]
fn the_manager_does_by_itself_what_a_task_can_ask_of_it() {
    let mut world = World::new(moded());
    world.log.files.insert("more.csv".into(), Ok(vec![task(7, 1.0)]));
    world.add([
        task(1, 50.0).categories(1),
        task(2, 50.0).at(100.0),
        built_in(3, BuiltIn::EnterMode("quiet".into())).at(5.0),
        built_in(4, BuiltIn::LeaveMode("quiet".into())).at(10.0),
        built_in(5, BuiltIn::Remove(vec![id(2)])).at(15.0),
        built_in(6, BuiltIn::Load("more.csv".into())).at(20.0),
        built_in(8, BuiltIn::Load("none.csv".into())).at(21.0),
        built_in(9, BuiltIn::Clear { all: true }).at(30.0),
    ]);
    world.until(60.0);
    assert_eq!(
        world.lines(&["paused", "resumed", "removed", "task 7 attempt 1 started", "task 8 failed"]),
        [
            "5.000 task 1 attempt 1 paused",
            "10.000 task 1 attempt 1 resumed",
            "15.000 task 2 removed",
            "20.000 task 7 attempt 1 started",
            "21.000 task 8 failed",
            "30.000 task 1 removed",
        ]
    );
    assert_eq!(world.lines(&["task 9 succeeded"]).len(), 1);
    assert!(world.manager().is_over());
}

#[test]
fn a_file_that_is_read_slowly_delays_nobody_and_is_loaded_when_it_was_read() {
    let mut world = World::of([
        built_in(1, BuiltIn::Load(SLOW.into())).at(5.0),
        task(2, 1.0).at(6.0),
        task(3, 1.0).at(50.0),
    ]);
    world.until(20.0);
    world.read_slowly(Ok(vec![task(7, 1.0)]));
    world.until(30.0);
    assert_eq!(
        world.lines(&["task 1 attempt", "started"]),
        [
            "5.000 task 1 attempt 1 started",
            "6.000 task 2 attempt 1 started",
            "20.000 task 1 attempt 1 succeeded (exit code 0)",
            "20.000 task 7 attempt 1 started",
        ]
    );
}

#[test]
fn a_load_that_was_stopped_while_its_file_was_read_adds_nothing() {
    let mut world = World::of([built_in(1, BuiltIn::Load(SLOW.into())), task(3, 1.0).at(50.0)]);
    world.until(5.0);
    assert_eq!(world.ask(Telecommand::Remove(vec![id(1)])), Reply::Done);
    world.until(10.0);
    world.read_slowly(Ok(vec![task(7, 1.0)]));
    world.until(20.0);
    assert_eq!(world.lines(&["task 1 aborted"]), ["5.000 task 1 aborted"]);
    assert_eq!(world.lines(&["task 7"]), [""; 0]);
    assert!(world.manager().task(id(7)).is_none());
}

#[test]
fn a_shut_down_manager_ends_what_runs_and_starts_nothing() {
    let mut world = World::of([
        task(1, 50.0).categories(1),
        task(2, 50.0).categories(1).priority(1).at(1.0),
        task(3, 5.0).at(3.0),
        task(4, 1.0).every(10.0),
    ]);
    world.until(2.0);
    world.ask(Telecommand::ShutDown);
    assert!(world.manager().is_over());
    world.until(50.0);
    assert_eq!(
        world.lines(&["aborted (", "task 3"]),
        [
            "2.000 task 1 attempt 1 aborted (signal 15)",
            "2.000 task 2 attempt 1 aborted (signal 15)"
        ]
    );
}

#[test]
fn status_tells_of_every_task_where_it_stands() {
    let mut world = World::of([
        task(1, 10.0).categories(1).priority(5).at(1.0),
        task(2, 10.0).categories(1).priority(4),
        task(3, 10.0).categories(1),
        task(4, 10.0).at(100.0),
        task(5, 1.0),
        task(6, 10.0).with(|task| task.windows[0].opens = wall(50)),
    ]);
    world.until(2.0);
    let status: Vec<_> = world.manager().status().collect();
    let states: Vec<_> = status
        .iter()
        .map(|status| match &status.state {
            State::Pending(due) => format!("pending {:?} {:?}", due.elapsed, due.wall),
            State::Waiting(why) => format!("waits for {why}"),
            State::Running(_) => "runs".into(),
            State::Stopping(_) => "stops".into(),
            State::Paused(_, why) => format!("paused, waits for {why}"),
            State::Ended(Outcome::Succeeded) => "ended".into(),
            State::Ended(_) => "not ended well".into(),
        })
        .collect();
    assert_eq!(states[0], "runs");
    assert_eq!(states[1], "paused, waits for categories 0x1, which task 1 has");
    assert_eq!(states[2], "waits for categories 0x1, which task 1 has");
    assert!(states[3].starts_with("pending Some"), "{states:?}");
    assert_eq!(states[4], "ended");
    assert!(states[5].starts_with("pending None"), "{states:?}");
    let of = |n: usize| world.manager().waits_for(status[n].occurrence);
    assert!(of(0).is_none() && of(2).is_some());
}

#[test]
fn of_the_tasks_that_ended_the_last_ones_are_remembered_and_can_be_cleared() {
    let most = u32::try_from(MOST_ENDED).unwrap();
    let mut world = World::of((1..=most + 2).map(|n| task(n, 0.0).at(f64::from(n))));
    let shown = |world: &World| {
        let ids = world.manager().status().map(|status| status.occurrence.task.get());
        ids.collect::<Vec<_>>()
    };
    world.until(f64::from(most));
    assert_eq!(shown(&world).len(), MOST_ENDED + 2, "two have not run");
    world.until(f64::from(most + 2));
    assert_eq!(shown(&world), (3..=most + 2).collect::<Vec<_>>());
    assert!(world.manager().is_over());
    // The journal forgets them, too, and an id is used again as another task's.
    assert_eq!(replay(world.journal.records.clone()).tasks.len(), MOST_ENDED);
    world.add([task(1, 1.0), task(5, 1.0)]);
    world.until(f64::from(most + 9));
    assert_eq!(world.lines(&["task 1 attempt 1 started", "task 5 attempt 1 started"]).len(), 4);
    assert_eq!(shown(&world).len(), MOST_ENDED);
    world.ask(Telecommand::Clear { all: false });
    assert_eq!(shown(&world), [0; 0]);
    assert!(replay(world.journal.records).tasks.is_empty());
}

/// What it depends on was there when it started.
#[test]
fn one_that_was_paused_does_not_wait_for_what_it_depended_on() {
    let dependant = task(2, 30.0).categories(1).with(|task| {
        let status = Status::Succeeded;
        task.after.push(Dependency { task: id(1), status });
    });
    let mut world = World::of([
        task(1, 1.0).every(100.0),
        dependant,
        task(3, 5.0).categories(1).priority(1).at(2.0),
    ]);
    world.until(3.0);
    let occurrence = world.manager().status().nth(1).unwrap().occurrence;
    assert_eq!(
        world.manager().waits_for(occurrence).unwrap().to_string(),
        "categories 0x1, which task 3 has"
    );
}

/// Who clears the schedule has the answer when it is durable, whoever it is.
#[test]
fn what_a_task_clears_is_durable_when_it_has_ended() {
    let mut world =
        World::of([task(1, 1.0).at(500.0), built_in(2, BuiltIn::Clear { all: false }).at(1.0)]);
    world.until(2.0);
    let is_end = |record: &Record| matches!(record, Record::Over { .. });
    let end = world.journal.records.iter().position(is_end).unwrap();
    let synced = world.journal.syncs.iter().rev().find(|sync| **sync <= end).copied().unwrap();
    let durable = &world.journal.records[..synced];
    assert!(durable.contains(&Record::Removed { task: id(1), load: 0 }), "{durable:#?}");
}
