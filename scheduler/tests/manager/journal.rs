//! What is written before what, and where a manager goes on.

use faregate_scheduler::Mission;
use faregate_scheduler::journal::replay;
use faregate_scheduler::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Occurrence, Record, Restored, RestoredTask,
    Telecommand, TelecommandId,
};
use faregate_scheduler::task::{Dependency, Outcome, Restart, Status, Task, When, Window};
use faregate_scheduler::time::{Instant, Now, UnixTime};

use crate::world::{BEGAN, With, World, id, seconds, task, wall};

fn occurrence(number: u64) -> Occurrence {
    Occurrence { task: id(1), load: 0, number }
}

/// What the first task does, in order, at these seconds.
fn acts(tasks: Vec<Task>, at: &[(f64, Vec<Event>)]) -> Vec<String> {
    let mut manager = Manager::new(Mission::default());
    let additions = tasks.into_iter().map(|task| Addition { task }).collect();
    let add = Event::Telecommand { id: TelecommandId(1), telecommand: Telecommand::Add(additions) };
    let mut actions = Vec::new();
    manager.step(Now::default(), vec![add], &mut actions);
    for (at, events) in at {
        let elapsed = Instant::from_micros(crate::world::us(*at));
        manager.step(Now { elapsed, ..Now::default() }, events.clone(), &mut actions);
    }
    let told = actions.iter().filter_map(|action| match action {
        Action::Journal(Record::Accepted { .. }) => Some("accepted".to_owned()),
        Action::Journal(Record::Armed { .. }) => Some("armed".to_owned()),
        Action::Journal(Record::Disarmed { .. }) => Some("disarmed".to_owned()),
        Action::Journal(Record::Starting { .. }) => Some("starting".to_owned()),
        Action::Journal(Record::Paused { paused, .. }) => Some(format!("paused {paused}")),
        Action::Journal(Record::Over { outcome, .. }) => Some(format!("over {outcome:?}")),
        Action::Journal(Record::Ended { outcome, .. }) => Some(format!("ended {outcome:?}")),
        Action::Sync => Some("sync".to_owned()),
        Action::Answer { .. } => Some("answer".to_owned()),
        Action::Start { .. } => Some("START".to_owned()),
        Action::Continue { .. } => Some("CONTINUE".to_owned()),
        Action::Relinquish { .. } => Some("RELINQUISH".to_owned()),
        _ => None,
    });
    told.collect()
}

fn granted() -> Event {
    Event::Granted { occurrence: occurrence(0) }
}

#[test]
fn a_timed_start_was_armed_and_pays_no_sync() {
    let told = acts(vec![task(1, 1.0).at(1.0)], &[(1.0, vec![]), (1.0, vec![granted()])]);
    assert_eq!(told, ["accepted", "sync", "answer", "armed", "sync", "starting", "START"]);
}

/// To arm whoever comes next takes a sync, for which a start would be late.
#[test]
fn a_timed_start_comes_before_the_next_one_is_armed() {
    let other = Occurrence { task: id(2), load: 0, number: 0 };
    let told = acts(
        vec![task(1, 1.0).at(1.0), task(2, 1.0).at(1.5), task(3, 1.0).at(2.0)],
        &[
            (1.0, vec![]),
            (1.0, vec![granted()]),
            (1.5, vec![]),
            (1.5, vec![Event::Blocked { occurrence: other, why: "a device".into() }]),
        ],
    );
    let loaded = ["accepted", "accepted", "accepted", "sync", "answer", "armed", "sync"];
    assert_eq!(told[..7], loaded);
    assert_eq!(told[7..11], ["starting", "START", "armed", "sync"], "after the first has started");
    assert_eq!(
        told[11..],
        ["disarmed", "armed", "sync"],
        "nor does the third wait for the second for ever"
    );
}

#[test]
fn a_start_that_nothing_was_prepared_for_is_synced() {
    // Due at once; due too soon to be armed; armed, and late for want of its category.
    let told = acts(vec![task(1, 1.0)], &[(0.0, vec![granted()])]);
    assert_eq!(told, ["accepted", "sync", "answer", "starting", "sync", "START"]);
    let told = acts(vec![task(1, 1.0).at(0.04)], &[(0.04, vec![]), (0.04, vec![granted()])]);
    assert_eq!(told, ["accepted", "sync", "answer", "starting", "sync", "START"]);
    let other = Occurrence { task: id(2), load: 0, number: 0 };
    let attempt = Attempt { occurrence: other, number: 1 };
    let told = acts(
        vec![task(1, 1.0).categories(1).at(1.0), task(2, 5.0).categories(1).priority(1)],
        &[
            (0.0, vec![Event::Granted { occurrence: other }]),
            (1.0, vec![]),
            (5.0, vec![Event::Exited { attempt, exit: Exit::Code(0) }]),
            (5.0, vec![granted()]),
        ],
    );
    assert_eq!(
        told[4..],
        [
            "starting",
            "sync",
            "START",
            "armed",
            "sync",
            "disarmed",
            "over Some(Succeeded)",
            "ended Succeeded",
            "RELINQUISH",
            "starting",
            "sync",
            "START",
        ]
    );
}

#[test]
fn an_end_and_a_pause_are_written_before_what_follows_from_them() {
    let attempt = Attempt { occurrence: occurrence(0), number: 1 };
    let taken = Event::Taken { occurrence: occurrence(0), by: "somebody".into() };
    let told = acts(
        vec![task(1, 10.0)],
        &[
            (0.0, vec![granted()]),
            (1.0, vec![taken]),
            (1.0, vec![Event::Stopped { attempt }]),
            (2.0, vec![granted()]),
            (11.0, vec![Event::Exited { attempt, exit: Exit::Code(1) }]),
        ],
    );
    assert_eq!(
        told[6..],
        [
            "paused true",
            "paused false",
            "CONTINUE",
            "over Some(Failed)",
            "ended Failed",
            "RELINQUISH",
        ]
    );
}

fn restored(task: Task) -> RestoredTask {
    RestoredTask {
        task,
        load: 0,
        position: 0,
        accepted: UnixTime::from_secs(BEGAN),
        held: false,
        over: false,
        ended: None,
        attempts: (0, 0),
        interrupted: None,
        may_have_started: false,
        has_to_clean: false,
        satisfied: vec![],
        leaving: false,
        cleans_up: false,
        ran_until: None,
    }
}

/// What happens after the manager was away for so many seconds.
fn after(task: RestoredTask, down_s: u64, until: f64) -> World {
    let restored = Restored { tasks: vec![task], modes: vec![], next_position: 1 };
    let mut world = World::restored(Mission::default(), restored, down_s);
    world.until(until);
    world
}

#[test]
fn what_had_not_started_starts_if_its_window_is_open() {
    let world = after(restored(task(1, 1.0).at(30.0)), 10, 60.0);
    assert_eq!(world.lines(&["started"]), ["20.000 task 1 attempt 1 started"], "+30 from the load");
    let world = after(restored(task(1, 1.0).at(5.0)), 10, 60.0);
    assert_eq!(world.lines(&["started"]), ["0.000 task 1 attempt 1 started"]);
    let world = after(restored(task(1, 1.0).at(5.0).closes(8.0)), 10, 60.0);
    assert_eq!(world.log.lines, ["0.000 task 1 missed occurrence 0: its window closed"]);
}

#[test]
fn an_interrupted_attempt_has_failed_and_is_tried_again_only_by_its_policy() {
    let interrupted = |task: Task| RestoredTask {
        attempts: (0, 1),
        interrupted: Some(Attempt { occurrence: occurrence(0), number: 1 }),
        ..restored(task)
    };
    let world = after(interrupted(task(1, 1.0)), 10, 60.0);
    assert_eq!(
        world.log.lines,
        [
            "0.000 task 1 attempt 1 failed (failed: interrupted: the manager ended)",
            "0.000 task 1 failed"
        ]
    );
    assert!(world.manager().is_over());
    let restart = Restart::OnFailure { limit: 1, back_off: seconds(3.0) };
    let world = after(interrupted(task(1, 1.0).with(|task| task.restart = restart)), 10, 60.0);
    assert_eq!(world.lines(&["started"]), ["3.000 task 1 attempt 2 started"]);
}

#[test]
fn one_that_may_have_started_is_not_started_twice() {
    let doubtful = RestoredTask { may_have_started: true, ..restored(task(1, 1.0)) };
    let world = after(doubtful, 10, 60.0);
    assert!(world.lines(&["1 started"]).is_empty());
    assert_eq!(world.lines(&["task 1 failed"]), ["0.000 task 1 failed"]);
}

#[test]
fn one_that_was_pre_empted_is_run_again_with_the_next_number() {
    let preempted = RestoredTask { attempts: (0, 2), ..restored(task(1, 1.0)) };
    let world = after(preempted, 10, 60.0);
    assert_eq!(world.lines(&["started"]), ["0.000 task 1 attempt 3 started"]);
}

/// Occurrence 0 has failed and waits for its next attempt; 1 and 2 were due
/// meanwhile, and are lost.
#[test]
fn one_that_waits_for_its_next_attempt_goes_on_though_later_ones_were_missed() {
    let restart = Restart::OnFailure { limit: 3, back_off: seconds(25.0) };
    let tried = |attempts| RestoredTask {
        attempts,
        ended: Some((2, Outcome::Missed)),
        ..restored(task(1, 1.0).every(10.0).with(|task| task.restart = restart))
    };
    let world = after(tried((0, 2)), 28, 20.0);
    assert_eq!(
        world.lines(&["missed", "started", "task 1 succeeded"]),
        [
            "0.000 task 1 attempt 3 started",
            "1.000 task 1 succeeded",
            "2.000 task 1 occurrence 3 attempt 1 started",
            "12.000 task 1 occurrence 4 attempt 1 started",
        ]
    );
    // The control: nothing of it waits.
    let world = after(tried((0, 0)), 28, 5.0);
    assert_eq!(world.lines(&["started"]), ["2.000 task 1 occurrence 3 attempt 1 started"]);
}

/// Its last occurrence was due when the time of day was a year later.
#[test]
fn a_clock_that_was_set_back_while_nobody_was_there_leaves_nobody_idle() {
    let absolute = task(1, 1.0).every(10.0).with(|task| task.windows[0].opens = wall(0));
    let ahead = RestoredTask { ended: Some((3_162_240, Outcome::Succeeded)), ..restored(absolute) };
    let world = after(ahead, 35, 18.0);
    assert_eq!(
        world.lines(&["missed", "started"]),
        [
            "5.000 task 1 occurrence 3162241 attempt 1 started",
            "15.000 task 1 occurrence 3162242 attempt 1 started",
        ]
    );
}

#[test]
fn a_routine_task_keeps_its_phase_and_what_was_due_meanwhile_is_missed() {
    let routine = RestoredTask {
        ended: Some((0, Outcome::Succeeded)),
        ..restored(task(1, 1.0).every(10.0).closes(2.0))
    };
    let world = after(routine, 35, 8.0);
    assert_eq!(
        world.lines(&["missed", "started"]),
        [
            "5.000 task 1 missed 3 occurrences, 1 to 3: its window closed",
            "5.000 task 1 occurrence 4 attempt 1 started",
        ]
    );
    // The present one, where its window is open.
    let absolute = task(1, 1.0).every(10.0).with(|task| task.windows[0].opens = wall(0));
    let routine = RestoredTask { ended: Some((0, Outcome::Succeeded)), ..restored(absolute) };
    let world = after(routine, 35, 8.0);
    assert_eq!(
        world.lines(&["missed", "started"]),
        [
            "0.000 task 1 missed 2 occurrences, 1 to 2: its time had passed",
            "0.000 task 1 occurrence 3 attempt 1 started",
            "5.000 task 1 occurrence 4 attempt 1 started",
        ]
    );
}

#[test]
fn a_held_task_stays_held_and_an_ended_one_ended() {
    let held = RestoredTask { held: true, ..restored(task(1, 1.0)) };
    assert!(after(held, 10, 60.0).lines(&["started"]).is_empty());
    let over =
        RestoredTask { over: true, ended: Some((0, Outcome::Succeeded)), ..restored(task(1, 1.0)) };
    let world = after(over, 10, 60.0);
    assert!(world.log.lines.is_empty());
    assert!(world.manager().is_over());
}

/// What cleans up after a task that failed does so, whenever the manager died.
#[test]
fn a_cleanup_is_not_forgotten() {
    let cleaned = task(1, 5.0).with(|task| task.cleanup = Some(id(9)));
    let pair = |cleaned: RestoredTask, has_to_clean| {
        let cleans_up = true;
        let cleanup =
            RestoredTask { position: 1, has_to_clean, cleans_up, ..restored(task(9, 1.0)) };
        let tasks = vec![cleaned, cleanup];
        let restored = Restored { tasks, modes: vec![], next_position: 2 };
        let mut world = World::restored(Mission::default(), restored, 10);
        world.until(60.0);
        world.lines(&["started"]).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let attempt = Attempt { occurrence: occurrence(0), number: 1 };
    let interrupted =
        RestoredTask { attempts: (0, 1), interrupted: Some(attempt), ..restored(cleaned.clone()) };
    let cleans = ["0.000 task 9 attempt 1 started"];
    assert_eq!(pair(interrupted, false), cleans, "it failed because the manager died");
    let failed =
        RestoredTask { over: true, ended: Some((0, Outcome::Failed)), ..restored(cleaned) };
    assert_eq!(pair(failed.clone(), true), cleans, "the manager died before it cleaned up");
    assert!(pair(failed, false).is_empty(), "it was cleaned up");
}

fn depends(task: Task, prior: u32, status: Status) -> Task {
    task.with(|task| task.after.push(Dependency { task: id(prior), status }))
}

/// The manager dies at this second, and comes back so many later.
fn interrupted(tasks: impl IntoIterator<Item = Task>, dies: f64, down_s: u64) -> World {
    let mut world = World::of(tasks);
    world.until(dies);
    World::restored(Mission::default(), replay(world.journal.records), down_s)
}

#[test]
fn what_an_outcome_of_a_routine_task_satisfied_is_not_forgotten() {
    let prior = || task(1, 1.0).every(1_000.0);
    let starts = |status| {
        let mut world = interrupted([prior(), depends(task(2, 1.0).at(50.0), 1, status)], 5.0, 10);
        world.until(100.0);
        world.lines(&["task 2"]).into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let started =
        ["40.000 task 2 attempt 1 started", "41.000 task 2 attempt 1 succeeded (exit code 0)"];
    assert_eq!(starts(Status::Succeeded)[..2], started);
    assert_eq!(starts(Status::Failed), [""; 0], "it was another outcome");
}

#[test]
fn an_outcome_of_a_routine_task_that_was_used_is_not_used_again() {
    let dependant = depends(task(2, 1.0).every(3.0), 1, Status::Succeeded);
    let mut world = interrupted([task(1, 1.0).every(10.0), dependant], 5.0, 6);
    world.until(6.0);
    // The first outcome came at 1 s, the second one comes at 11.
    assert_eq!(
        world.lines(&["started"]),
        [
            "4.000 task 1 occurrence 1 attempt 1 started",
            "5.000 task 2 occurrence 3 attempt 1 started",
        ]
    );
}

/// Who was interrupted has failed, and who waits for that has its own time.
#[test]
fn the_failure_of_who_was_interrupted_starts_nobody_before_its_time() {
    let dependant = depends(task(2, 1.0).at(50.0), 1, Status::Failed);
    let mut world = interrupted([task(1, 20.0), dependant], 5.0, 10);
    world.until(100.0);
    assert_eq!(world.lines(&["started"]), ["40.000 task 2 attempt 1 started"]);
}

#[test]
fn who_was_interrupted_has_failed_even_if_later_occurrences_were_missed_meanwhile() {
    let routine = task(1, 60.0).every(10.0).with(|task| task.cleanup = Some(id(9)));
    let mut world = interrupted([routine, task(9, 1.0)], 35.0, 35);
    world.until(6.0);
    assert_eq!(
        world.log.lines,
        [
            "0.000 task 1 attempt 1 failed (failed: interrupted: the manager ended)",
            "0.000 task 1 failed",
            "0.000 task 9 attempt 1 started",
            "1.000 task 9 attempt 1 succeeded (exit code 0)",
            "1.000 task 9 succeeded",
            "5.000 task 1 occurrence 4 attempt 1 started",
        ]
    );
}

#[test]
fn what_was_missed_while_the_manager_was_away_is_an_outcome_too() {
    let routine = task(1, 1.0).every(10.0).closes(2.0);
    let dependant = depends(task(2, 1.0), 1, Status::Missed);
    let mut world = interrupted([routine, dependant], 5.0, 35);
    world.until(4.0);
    assert_eq!(world.lines(&["started"]), ["0.000 task 2 attempt 1 started"]);
}

/// What a manager writes until it dies, which does these at 0 s.
fn written(tasks: Vec<Task>, steps: Vec<Vec<Event>>) -> Vec<Record> {
    let mut manager = Manager::new(Mission::default());
    let additions = tasks.into_iter().map(|task| Addition { task }).collect();
    let telecommand = Telecommand::Add(additions);
    let add = Event::Telecommand { id: TelecommandId(0), telecommand };
    let now = Now { wall: UnixTime::from_secs(BEGAN), ..Now::default() };
    let mut actions = Vec::new();
    for events in [vec![add]].into_iter().chain(steps) {
        manager.step(now, events, &mut actions);
    }
    let records = actions.into_iter().filter_map(|action| match action {
        Action::Journal(record) => Some(record),
        _ => None,
    });
    records.collect()
}

fn command(telecommand: Telecommand) -> Vec<Event> {
    vec![Event::Telecommand { id: TelecommandId(1), telecommand }]
}

/// It was told to end, and the manager died before it had.
#[test]
fn one_that_was_removed_while_it_ran_does_not_come_back() {
    let restart = Restart::OnFailure { limit: 9, back_off: seconds(1.0) };
    let tried = || task(1, 60.0).with(|task| task.restart = restart);
    let cleaned = tried().every(100.0).with(|task| task.cleanup = Some(id(9)));
    for (tasks, cleans) in [(vec![tried()], 0), (vec![cleaned, task(9, 1.0)], 1)] {
        let steps = vec![vec![granted()], command(Telecommand::Remove(vec![id(1)]))];
        let restored = replay(written(tasks, steps));
        let mut world = World::restored(Mission::default(), restored, 5);
        world.until(500.0);
        assert!(world.lines(&["task 1 attempt 2", "task 1 occurrence"]).is_empty());
        assert_eq!(world.lines(&["task 9 attempt 1 started"]).len(), cleans);
        assert!(world.manager().is_over(), "{:#?}", world.log.lines);
    }
}

#[test]
fn what_ran_when_the_schedule_was_cleared_does_not_come_again() {
    let routine = vec![task(1, 60.0).every(100.0)];
    let steps = vec![vec![granted()], command(Telecommand::Clear { all: false })];
    let restored = replay(written(routine, steps));
    let mut world = World::restored(Mission::default(), restored, 5);
    world.until(500.0);
    assert_eq!(world.lines(&["task 1 failed"]).len(), 1, "it was interrupted");
    assert!(world.lines(&["started"]).is_empty());
    assert!(world.manager().is_over());
}

#[test]
fn a_cleanup_never_starts_by_itself_whoever_is_left_after_a_restart() {
    let cleaned = task(1, 1.0).at(100.0).with(|task| task.cleanup = Some(id(9)));
    let mut world = World::of([cleaned, task(9, 1.0)]);
    world.ask(Telecommand::Remove(vec![id(1)]));
    let mut world = World::restored(Mission::default(), replay(world.journal.records), 10);
    world.until(500.0);
    assert!(world.lines(&["started"]).is_empty(), "{:#?}", world.log.lines);
    assert_eq!(world.manager().status().count(), 0);
}

#[test]
fn a_cleanup_that_was_never_needed_is_not_there_after_a_restart() {
    let cleaned = task(1, 1.0).with(|task| task.cleanup = Some(id(9)));
    let mut world = World::of([cleaned, task(9, 1.0)]);
    world.until(5.0);
    let world = World::restored(Mission::default(), replay(world.journal.records), 10);
    let shown: Vec<_> = world.manager().status().map(|status| status.occurrence.task).collect();
    assert_eq!(shown, [id(1)]);
}

/// One that only has the id of a cleanup is a task like any other.
#[test]
fn a_task_that_has_the_id_of_a_cleanup_that_is_over_starts_after_a_restart() {
    let cleaned = task(1, 1.0).with(|task| task.cleanup = Some(id(9)));
    let mut world = World::of([cleaned, task(9, 1.0)]);
    world.until(5.0);
    world.add([task(9, 1.0).at(100.0)]);
    let mut world = World::restored(Mission::default(), replay(world.journal.records), 10);
    world.until(500.0);
    assert_eq!(world.lines(&["started"]).len(), 1, "{:#?}", world.log.lines);
}

/// A loss of power long before it is due leaves no doubt whether it started.
#[test]
fn a_task_is_armed_shortly_before_it_is_due() {
    let long_before = acts(vec![task(1, 1.0).at(100.0)], &[(89.9, vec![])]);
    assert_eq!(long_before, ["accepted", "sync", "answer"]);
    let mut world = World::of([task(1, 1.0).at(100.0)]);
    let is_armed = |world: &World| {
        let armed = |record: &Record| matches!(record, Record::Armed { .. });
        world.journal.records.iter().any(armed)
    };
    world.until(89.9);
    assert!(!is_armed(&world));
    world.until(90.1);
    assert!(is_armed(&world), "nobody has to ask for that");
}

#[test]
fn who_is_put_off_is_not_armed_any_more() {
    let mut world = World::of([task(1, 1.0).at(5.0)]);
    world.until(1.0);
    let windows = vec![Window { opens: wall(1_000), closes: When::Unrestricted }];
    world.ask(Telecommand::SetWindows(id(1), windows));
    let told = world
        .journal
        .records
        .iter()
        .filter(|record| matches!(record, Record::Armed { .. } | Record::Disarmed { .. }));
    let occurrence = occurrence(0);
    let expected = [Record::Armed { occurrence }, Record::Disarmed { occurrence }];
    assert!(told.eq(expected.iter()));
}

#[test]
fn a_gap_is_as_long_whoever_is_the_manager_at_its_end() {
    let spaced = |task: Task| task.categories(1).with(|task| task.gap = seconds(60.0));
    let other = || task(2, 1.0).categories(1).at(10.0);
    for (first, down_s, starts) in [
        (task(1, 5.0), 15, "50.000 task 2 attempt 1 started"),
        (task(1, 5.0).every(1_000.0), 15, "50.000 task 2 attempt 1 started"),
        (task(1, 5.0), 70, "0.000 task 2 attempt 1 started"),
        // The clock was set back: nobody knows how much of it is over.
        (task(1, 5.0), 1, "60.000 task 2 attempt 1 started"),
    ] {
        let mut world = interrupted([spaced(first), other()], 7.0, down_s);
        world.until(100.0);
        assert_eq!(world.lines(&["started"]), [starts]);
    }
}
