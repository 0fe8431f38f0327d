//! When an attempt may start, and what becomes of one that could not.

use faregate_scheduler::task::{CheckpointSignal, Preemption, Window};

use crate::world::{With, World, seconds, task, wall};

#[test]
fn the_end_of_a_window_is_the_latest_start_and_belongs_to_it() {
    for (closes, starts) in [(10.0, true), (9.999, false)] {
        let first = task(1, 10.0).categories(1).priority(5);
        let second = task(2, 1.0).categories(1).closes(closes);
        let mut world = World::of([first, second]);
        world.until(60.0);
        assert_eq!(world.lines(&["task 2 attempt 1 started"]).len(), usize::from(starts));
        assert_eq!(world.lines(&["task 2 missed"]).len(), usize::from(!starts));
        assert!(world.manager().is_over());
    }
}

#[test]
fn a_start_in_the_past_without_an_end_starts_at_once() {
    let mut world = World::of([task(1, 1.0).with(|task| task.windows[0].opens = wall(-100))]);
    world.until(0.5);
    assert_eq!(world.lines(&["started"]), ["0.000 task 1 attempt 1 started"]);
}

#[test]
fn a_window_that_has_passed_at_the_load_is_missed_at_once() {
    let mut world = World::of([task(1, 1.0).with(|task| {
        task.windows[0] = Window { opens: wall(-100), closes: wall(-1) };
    })]);
    world.until(0.5);
    assert_eq!(world.log.lines, ["0.000 task 1 missed occurrence 0: its window closed"]);
}

#[test]
fn the_first_window_that_is_open_counts() {
    let window = |opens, closes| {
        let task = task(1, 1.0).at(opens).closes(closes);
        task.windows[0]
    };
    let blocker = task(2, 30.0).categories(1).priority(9);
    let mut world = World::of([
        blocker,
        task(1, 1.0)
            .categories(1)
            .with(|task| task.windows = vec![window(5.0, 10.0), window(40.0, 50.0)]),
    ]);
    world.until(100.0);
    assert_eq!(world.lines(&["task 1 attempt 1 started"]), ["40.000 task 1 attempt 1 started"]);
    assert!(world.lines(&["missed"]).is_empty());
}

#[test]
fn resuming_is_no_start_but_running_again_after_a_kill_is_one() {
    let kill = Preemption::Kill { grace: seconds(0.0) };
    for (preemption, succeeds) in [(Preemption::Pause, true), (kill, false)] {
        let first = task(1, 20.0).categories(1).closes(4.0);
        let first = first.with(|task| task.preemption = preemption);
        let second = task(2, 10.0).categories(1).priority(1).at(5.0);
        let mut world = World::of([first, second]);
        world.until(100.0);
        assert_eq!(world.lines(&["task 1 succeeded"]).len(), usize::from(succeeds));
        assert_eq!(world.lines(&["task 1 missed"]).len(), usize::from(!succeeds));
    }
}

/// What a checkpoint saved is gone on with, like what a pause kept.
#[test]
fn running_again_after_a_checkpoint_is_no_start() {
    let preemption =
        Preemption::Checkpoint { grace: seconds(1.0), signal: CheckpointSignal::User1 };
    let first = task(1, 20.0).categories(1).closes(4.0);
    let first = first.with(|task| task.preemption = preemption);
    let second = task(2, 10.0).categories(1).priority(1).at(5.0);
    let mut world = World::of([first, second]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["task 1 attempt 2 started", "task 1 succeeded", "missed"]),
        ["16.000 task 1 attempt 2 started", "31.000 task 1 succeeded"],
        "{:#?}",
        world.log.lines
    );
}

#[test]
fn an_attempt_is_aborted_at_its_cutoff_running_or_paused() {
    for pauses in [false, true] {
        let cutoff = task(0x7fff, 1.0).at(8.0).windows[0].opens;
        let first = task(1, 20.0).categories(1).with(|task| task.cutoff = cutoff);
        let mut world = World::of([first]);
        if pauses {
            world.add([task(2, 100.0).categories(1).priority(1).at(5.0)]);
        }
        world.until(50.0);
        assert_eq!(
            world.lines(&["task 1 aborted", "task 1 missed"]),
            ["8.000 task 1 aborted"],
            "{:?}",
            world.log.lines
        );
    }
}

#[test]
fn a_jump_of_the_clock_makes_passed_windows_missed_and_starts_once_what_is_due() {
    let passed =
        task(1, 1.0).with(|task| task.windows[0] = Window { opens: wall(100), closes: wall(200) });
    let due = task(2, 1.0).with(|task| task.windows[0].opens = wall(100));
    let relative = task(3, 1.0).at(500.0);
    let mut world = World::of([passed, due, relative]);
    world.until(10.0);
    world.jump(1_000);
    world.until(20.0);
    assert_eq!(
        world.lines(&["missed", "started"]),
        ["10.000 task 1 missed occurrence 0: its window closed", "10.000 task 2 attempt 1 started"]
    );
    world.jump(-2_000);
    world.until(600.0);
    assert_eq!(world.lines(&["task 2 attempt"]).len(), 2, "started once, and over once");
    assert_eq!(world.lines(&["task 3 attempt 1 started"])[0], "500.000 task 3 attempt 1 started");
}

#[test]
fn what_was_due_and_waits_is_not_due_any_more_when_the_clock_is_set_back() {
    let blocker = task(1, 20.0).categories(1).priority(9);
    let due = task(2, 1.0).categories(1).with(|task| task.windows[0].opens = wall(10));
    let mut world = World::of([blocker, due]);
    world.until(15.0);
    world.jump(-100);
    world.until(200.0);
    assert_eq!(world.lines(&["task 2 attempt 1 started"]), ["110.000 task 2 attempt 1 started"]);
}

#[test]
fn a_task_whose_window_is_one_instant_starts_although_the_manager_is_woken_late() {
    for (late, starts) in [(0.08, true), (0.2, false)] {
        let mut world = World::of([task(1, 1.0).at(10.0).closes(10.0)]);
        world.until(5.0);
        world.elapsed_us = crate::world::us(10.0 + late);
        world.settle();
        assert_eq!(world.lines(&["started"]).len(), usize::from(starts), "{late}");
        world.until(30.0);
        assert_eq!(world.lines(&["missed"]).len(), usize::from(!starts), "{late}");
    }
}
