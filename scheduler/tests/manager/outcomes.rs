//! What the end of a body means, and what follows.

use faregate_scheduler::manager::{Event, Exit, Reading};
use faregate_scheduler::task::{Body, Overrun, Preemption, Restart, When, Window};

use crate::world::{With, World, id, seconds, task};

fn attempt(number: u32) -> faregate_scheduler::manager::Attempt {
    let occurrence = faregate_scheduler::manager::Occurrence { task: id(1), load: 0, number: 0 };
    faregate_scheduler::manager::Attempt { occurrence, number }
}

#[test]
fn anything_but_success_is_a_failure() {
    let failed = "it was refused".to_owned();
    for exit in [
        Exit::Code(1),
        Exit::Signal(9),
        Exit::Panicked(failed.clone()),
        Exit::Failed(failed.clone()),
        Exit::NotStarted(failed),
    ] {
        let mut world = World::ending([task(1, 1.0)], &[(1, exit)]);
        world.until(10.0);
        assert_eq!(world.lines(&["task 1 failed"]), ["1.000 task 1 failed"]);
        assert_eq!(world.lines(&["1 started"]).len(), 1, "at most once");
    }
}

#[test]
fn a_failed_task_is_tried_again_as_often_and_as_late_as_it_says() {
    let restart = Restart::OnFailure { limit: 2, back_off: seconds(5.0) };
    let tried = task(1, 1.0).with(|task| task.restart = restart);
    let mut world = World::ending([tried], &[(1, Exit::Code(1))]);
    world.until(60.0);
    assert_eq!(
        world.lines(&["started", "task 1 failed"]),
        [
            "0.000 task 1 attempt 1 started",
            "6.000 task 1 attempt 2 started",
            "12.000 task 1 attempt 3 started",
            "13.000 task 1 failed",
        ]
    );
}

#[test]
fn a_restart_must_find_an_open_window() {
    let restart = Restart::OnFailure { limit: 9, back_off: seconds(5.0) };
    let tried = task(1, 1.0).closes(7.0).with(|task| task.restart = restart);
    let mut world = World::ending([tried], &[(1, Exit::Code(1))]);
    world.until(60.0);
    assert_eq!(world.lines(&["started"]).len(), 2);
    assert_eq!(world.lines(&["missed"]), ["7.000 task 1 missed occurrence 0: its window closed"]);
}

#[test]
fn an_overrun_is_reported_once_and_its_policy_decides() {
    for (overrun, starts, end) in [
        (Overrun::Report, 1, "20.000 task 1 succeeded"),
        (Overrun::Abort, 1, "5.100 task 1 aborted"),
        (Overrun::AbortAndRestart, 2, "10.200 task 1 failed"),
    ] {
        let slow = task(1, 5.0).with(|task| {
            task.overrun = overrun;
            task.restart = Restart::OnFailure { limit: 1, back_off: seconds(0.0) };
        });
        let bodies = faregate_scheduler::executive::VirtualBodies::new(|_, _| {
            faregate_scheduler::executive::Conduct::succeeds_after(seconds(20.0))
        });
        let mut world = World::with_bodies(Default::default(), bodies);
        world.add([slow]);
        world.until(60.0);
        assert_eq!(world.lines(&["runs longer"]).len(), starts, "{:#?}", world.log.lines);
        assert_eq!(world.lines(&["started"]).len(), starts);
        assert_eq!(world.log.lines.last().unwrap(), end);
    }
}

#[test]
fn time_paused_is_no_overrun() {
    let first = task(1, 10.0).categories(1).with(|task| task.overrun = Overrun::Abort);
    let second = task(2, 30.0).categories(1).priority(1).at(5.0);
    let mut world = World::of([first, second]);
    world.until(100.0);
    assert!(world.lines(&["runs longer"]).is_empty());
    assert_eq!(world.lines(&["task 1 succeeded"]), ["40.000 task 1 succeeded"]);
}

#[test]
fn one_that_is_silent_for_longer_than_its_heartbeat_has_failed() {
    let beating = task(1, 60.0).with(|task| task.heartbeat = Some(seconds(2.0)));
    let mut world = World::of([beating]);
    for second in 1..=6 {
        world.until(f64::from(second));
        world.tell(Event::Heartbeat { attempt: attempt(1) });
    }
    world.until(60.0);
    assert_eq!(
        world.lines(&["stopped", "task 1 failed"]),
        [
            "8.000 task 1 attempt 1 is being stopped: it was silent for longer than its heartbeat",
            "8.000 task 1 failed",
        ]
    );
}

#[test]
fn one_that_uses_more_than_twice_its_memory_has_failed() {
    for (used, fails) in [(200, false), (201, true)] {
        let mut world = World::of([task(1, 10.0).with(|task| task.memory = 100)]);
        world.until(5.0);
        world.tell(Event::Reading(Reading::Used { attempt: attempt(1), memory: used }));
        world.until(20.0);
        assert_eq!(world.lines(&["task 1 failed"]).len(), usize::from(fails));
    }
}

#[test]
fn an_end_that_comes_with_the_news_of_a_pre_emption_is_an_end() {
    let kill = Preemption::Kill { grace: seconds(1.0) };
    let mut world = World::of([task(1, 10.0).with(|task| task.preemption = kill)]);
    world.until(5.0);
    let occurrence = attempt(1).occurrence;
    world.tell_later(Event::Taken { occurrence, by: "somebody".into() });
    world.tell(Event::Exited { attempt: attempt(1), exit: Exit::Code(0) });
    assert_eq!(world.lines(&["task 1 succeeded"]).len(), 1);
}

#[test]
fn a_function_that_does_not_return_keeps_its_categories_until_it_does() {
    let signal = faregate_scheduler::task::CheckpointSignal::User1;
    let stuck = task(1, 100.0).categories(1).with(|task| {
        task.body = Body::Function { number: 16, arguments: vec![] };
        task.preemption = Preemption::Checkpoint { grace: seconds(50.0), signal };
    });
    let mut world = World::of([stuck, task(2, 5.0).categories(1).priority(9).at(5.0)]);
    world.until(6.0);
    world.tell(Event::Runaway { attempt: attempt(1) });
    world.until(54.0);
    assert!(world.lines(&["task 2 attempt 1 started"]).is_empty());
    world.until(70.0);
    assert_eq!(
        world.lines(&["did not return", "task 2 attempt 1 started"]),
        [
            "6.000 task 1 attempt 1 did not return: its worker is lost",
            "55.000 task 2 attempt 1 started",
        ]
    );
}

/// Of its windows one closes while it waits, and the other one opens too early.
#[test]
fn a_restart_waits_for_its_back_off_whatever_its_windows_do() {
    let restart = Restart::OnFailure { limit: 1, back_off: seconds(30.0) };
    let window = |opens: f64, closes: f64| Window {
        opens: When::AfterLoad(seconds(opens)),
        closes: When::AfterLoad(seconds(closes)),
    };
    let tried = task(1, 1.0).with(|task| {
        task.restart = restart;
        task.windows = vec![window(0.0, 5.0), window(10.0, 60.0)];
    });
    let mut world = World::ending([tried], &[(1, Exit::Code(1))]);
    world.until(100.0);
    assert_eq!(
        world.lines(&["started"]),
        ["0.000 task 1 attempt 1 started", "31.000 task 1 attempt 2 started"]
    );
}
