//! Who loses tickets, and what becomes of it.

use faregate_scheduler::task::{CheckpointSignal, Preemption};

use crate::world::{With, World, seconds, task};

#[test]
fn one_that_is_checkpointed_has_its_grace_and_runs_again_as_a_new_attempt() {
    let checkpoint =
        Preemption::Checkpoint { grace: seconds(2.0), signal: CheckpointSignal::User1 };
    let first = task(1, 20.0).categories(1).with(|task| task.preemption = checkpoint);
    let second = task(2, 5.0).categories(1).priority(1).at(5.0);
    let mut world = World::of([first, second]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["attempt"]),
        [
            "0.000 task 1 attempt 1 started",
            "5.000 task 1 attempt 1 is being stopped: task 2",
            "7.000 task 1 attempt 1 pre-empted, to be run again",
            "7.000 task 2 attempt 1 started",
            "12.000 task 2 attempt 1 succeeded (exit code 0)",
            "12.000 task 1 attempt 2 started",
            "27.000 task 1 attempt 2 succeeded (exit code 0)",
        ]
    );
}

#[test]
fn one_that_is_killed_begins_again() {
    let kill = Preemption::Kill { grace: seconds(1.0) };
    let first = task(1, 20.0).categories(1).with(|task| task.preemption = kill);
    let second = task(2, 5.0).categories(1).priority(1).at(5.0);
    let mut world = World::of([first, second]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["task 1 attempt 2"]),
        ["10.000 task 1 attempt 2 started", "30.000 task 1 attempt 2 succeeded (exit code 0)"]
    );
}

#[test]
fn no_task_takes_the_tickets_of_one_that_waits() {
    let first = task(1, 20.0).categories(1).with(|task| task.preemption = Preemption::Wait);
    let second = task(2, 5.0).categories(1).priority(239).at(5.0);
    let mut world = World::of([first, second]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["started", "waits"]),
        [
            "0.000 task 1 attempt 1 started",
            "5.000 task 2 waits for categories 0x1, which task 1 has",
            "20.000 task 2 attempt 1 started",
        ]
    );
}

#[test]
fn one_that_cannot_be_pre_empted_does_not_keep_a_more_important_one_waiting() {
    let running = task(1, 10.0).categories(1).with(|task| task.preemption = Preemption::Wait);
    let important = task(2, 5.0).categories(3).priority(5).at(1.0);
    let waits = task(3, 60.0).categories(2).priority(1).at(2.0);
    let waits = waits.with(|task| task.preemption = Preemption::Wait);
    let mut world = World::of([running, important, waits.clone()]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["task 2 attempt 1 started", "task 3 waits", "task 3 attempt 1 started"]),
        [
            "2.000 task 3 waits for task 2, which is more important",
            "10.000 task 3 waits for categories 0x2, which task 2 has",
            "10.000 task 2 attempt 1 started",
            "15.000 task 3 attempt 1 started",
        ]
    );

    // One that can be pre-empted may use it meanwhile, and gives it back.
    let pauses = waits.with(|task| task.preemption = Preemption::Pause);
    let running = task(1, 10.0).categories(1).with(|task| task.preemption = Preemption::Wait);
    let important = task(2, 5.0).categories(3).priority(5).at(1.0);
    let mut world = World::of([running, important, pauses]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["started", "paused", "resumed"]),
        [
            "0.000 task 1 attempt 1 started",
            "2.000 task 3 attempt 1 started",
            "10.000 task 3 attempt 1 paused",
            "10.000 task 2 attempt 1 started",
            "15.000 task 3 attempt 1 resumed",
        ]
    );
}

#[test]
fn no_victim_is_taken_unless_the_whole_request_can_be_had() {
    let fixed = task(1, 30.0).categories(1).with(|task| task.preemption = Preemption::Wait);
    let modest = task(2, 30.0).categories(2);
    let greedy = task(3, 5.0).categories(3).priority(9).at(5.0);
    let mut world = World::of([fixed, modest, greedy]);
    world.until(29.0);
    assert!(world.lines(&["paused", "stopped"]).is_empty(), "{:#?}", world.log.lines);
    world.until(100.0);
    assert_eq!(world.lines(&["task 3 attempt 1 started"])[0], "30.000 task 3 attempt 1 started");
}

#[test]
fn two_that_fit_singly_and_not_together_run_one_after_the_other_and_say_for_whom() {
    let mut world = World::of([task(1, 10.0).categories(0b011), task(2, 10.0).categories(0b110)]);
    world.until(5.0);
    assert_eq!(
        world.news(),
        [
            "0.000 task 2 waits for categories 0x2, which task 1 has",
            "0.000 task 1 attempt 1 started"
        ]
    );
    world.until(100.0);
    assert_eq!(world.lines(&["task 2 attempt 1 started"])[0], "10.000 task 2 attempt 1 started");
}

#[test]
fn among_equals_who_was_due_first_goes_first_and_then_who_stands_first() {
    let early = task(9, 5.0).categories(1).at(1.0);
    let late = task(1, 5.0).categories(1).at(2.0);
    let same = task(8, 5.0).categories(1).at(2.0);
    let running = task(5, 3.0).categories(1);
    let mut world = World::of([late, same, early, running]);
    world.until(100.0);
    let order: Vec<_> = world.lines(&["started"]).into_iter().map(|line| &line[..13]).collect();
    assert_eq!(order, ["0.000 task 5 ", "3.000 task 9 ", "8.000 task 1 ", "13.000 task 8"]);
}
