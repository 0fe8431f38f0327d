//! Sequences and holds: what happens when, and what a pause does to it.

use std::sync::Arc;

use crossbeam::channel::{Receiver, Sender, bounded, unbounded};
use faregate_scheduler::bodies::{Settings, Surroundings};
use faregate_scheduler::executive::{Bodies, CommandRefused, Commands, RefusedKind};
use faregate_scheduler::manager::{Attempt, Event, Exit, Stop};
use faregate_scheduler::task::{Body, Step};
use faregate_scheduler::time::Duration;

use super::bench::Bench;

type Answer = Result<String, CommandRefused>;

/// Devices that tell the test of each command, and answer what it says.
struct Devices {
    commands: Sender<String>,
    answers: Receiver<Answer>,
    wcet: Option<Duration>,
}

impl Commands for Devices {
    fn command(&self, _: Attempt, gate: &str, command: &str, arguments: &[String]) -> Answer {
        self.commands.send(format!("{gate} {command} {}", arguments.join(" "))).unwrap();
        self.answers.recv().unwrap_or_else(|_| refused(RefusedKind::Fault, "the test is over"))
    }

    fn wcet(&self, _: &str, _: &str) -> Option<Duration> {
        self.wcet
    }
}

fn refused(kind: RefusedKind, reason: &str) -> Answer {
    Err(CommandRefused::new(kind, reason))
}

fn done() -> Answer {
    Ok("done".into())
}

/// The test's side of the devices.
struct Desk {
    commands: Receiver<String>,
    answers: Sender<Answer>,
}

fn bench(wcet: Option<Duration>) -> (Bench, Desk) {
    let (told, commands) = unbounded();
    let (answers, asked) = bounded(0);
    let devices = Devices { commands: told, answers: asked, wcet };
    let around = Surroundings { commands: Arc::new(devices), ..Surroundings::default() };
    (Bench::around(Settings::default(), around), Desk { commands, answers })
}

fn step(offset_ms: u64, command: &str) -> Step {
    Step {
        offset: Duration::from_millis(offset_ms),
        gate: "camera".into(),
        command: command.into(),
        arguments: vec!["1".into()],
        continues: false,
    }
}

#[test]
fn commands_are_issued_in_order_and_each_waits_for_the_one_before() {
    let (mut bench, desk) = bench(None);
    let attempt =
        bench.start(Body::Sequence(vec![step(0, "on"), step(0, "shoot"), step(5, "off")]));
    assert_eq!(desk.commands.recv().unwrap(), "camera on 1");
    bench.bodies_poll();
    assert!(desk.commands.is_empty(), "the second did not wait for the first");
    desk.answers.send(done()).unwrap();
    let mut bench = answer_next(bench, &desk, "camera shoot 1");
    bench = answer_next(bench, &desk, "camera off 1");
    assert_eq!(bench.exit(attempt), Exit::Code(0));
}

/// Waits for this command, as a manager that has nothing else to do.
fn answer_next(mut bench: Bench, desk: &Desk, expected: &str) -> Bench {
    while desk.commands.is_empty() {
        bench.turn();
        let command = desk.commands.recv_timeout(std::time::Duration::from_millis(5));
        if let Ok(command) = command {
            assert_eq!(command, expected);
            desk.answers.send(done()).unwrap();
            return bench;
        }
    }
    assert_eq!(desk.commands.recv().unwrap(), expected);
    desk.answers.send(done()).unwrap();
    bench
}

#[test]
fn a_refused_command_ends_the_sequence_unless_the_step_says_otherwise() {
    for continues in [false, true] {
        let (mut bench, desk) = bench(None);
        let first = Step { continues, ..step(0, "on") };
        let attempt = bench.start(Body::Sequence(vec![first, step(0, "off")]));
        desk.commands.recv().unwrap();
        desk.answers.send(refused(RefusedKind::NotNow, "too hot")).unwrap();
        let exit = if continues {
            answer_next(bench, &desk, "camera off 1").exit(attempt)
        } else {
            bench.exit(attempt)
        };
        let failed = Exit::Failed("step 1 (camera on): too hot".into());
        assert_eq!(exit, if continues { Exit::Code(0) } else { failed });
    }
}

#[test]
fn a_paused_sequence_stands_still_and_goes_on_where_it_was() {
    let (mut bench, desk) = bench(None);
    let attempt = bench.start(Body::Sequence(vec![step(0, "on"), step(40, "off")]));
    desk.commands.recv().unwrap();
    desk.answers.send(done()).unwrap();
    bench.pause(attempt);
    assert_eq!(bench.bodies.next_due(), None, "the time of a step comes during the pause");
    // Far longer than the offset.
    super::look::real_time(std::time::Duration::from_millis(100));
    bench.bodies_poll();
    bench.resume(attempt);
    let (due, now) = (bench.bodies.next_due().unwrap(), bench.now().elapsed);
    assert!(desk.commands.is_empty() && due > now, "the pause counted: due {due:?} at {now:?}");
    assert_eq!(answer_next(bench, &desk, "camera off 1").exit(attempt), Exit::Code(0));
}

#[test]
fn a_pause_waits_for_the_command_in_progress() {
    let (mut bench, desk) = bench(None);
    let attempt = bench.start(Body::Sequence(vec![step(0, "on")]));
    desk.commands.recv().unwrap();
    bench.stop(attempt, Stop::Pause);
    bench.bodies_poll();
    assert_eq!(bench.told(), [], "it does not stand still");
    desk.answers.send(done()).unwrap();
    bench.stopped(attempt);
    bench.resume(attempt);
    assert_eq!(bench.exit(attempt), Exit::Code(0));
}

#[test]
fn a_command_refused_because_the_tickets_were_taken_is_tried_again_after_the_pause() {
    for stopped_first in [false, true] {
        let (mut bench, desk) = bench(None);
        let attempt = bench.start(Body::Sequence(vec![step(0, "on")]));
        desk.commands.recv().unwrap();
        if stopped_first {
            bench.stop(attempt, Stop::Pause);
        }
        desk.answers.send(refused(RefusedKind::Taken, "task 9 has it")).unwrap();
        if !stopped_first {
            bench.turn();
            assert_eq!(bench.told(), [], "the refusal ended it");
            bench.stop(attempt, Stop::Pause);
        }
        bench.stopped(attempt);
        bench.resume(attempt);
        assert_eq!(answer_next(bench, &desk, "camera on 1").exit(attempt), Exit::Code(0));
    }
}

/// The manager's thread waited for its disk: it hears of the refusal and of what
/// has taken the tickets in one turn, in this order.
#[test]
fn a_stop_that_comes_in_a_late_turn_is_not_too_late() {
    let (mut bench, desk) = bench(None);
    let attempt = bench.start(Body::Sequence(vec![step(0, "on")]));
    desk.commands.recv().unwrap();
    desk.answers.send(refused(RefusedKind::Taken, "task 9 has it")).unwrap();
    bench.turn();
    // Longer than a stop is waited for.
    super::look::real_time(std::time::Duration::from_millis(1_100));
    bench.bodies_poll();
    let other = bench.start_for(Body::Hold, Duration::from_secs(1000));
    assert_eq!(bench.told(), [], "it has failed before its stop could come");
    bench.pause(attempt);
    bench.resume(attempt);
    assert_eq!(bench.kill(other, Duration::ZERO), Exit::Signal(15));
    assert_eq!(answer_next(bench, &desk, "camera on 1").exit(attempt), Exit::Code(0));
}

#[test]
fn a_command_refused_as_taken_ends_the_sequence_when_no_stop_follows() {
    let (mut bench, desk) = bench(None);
    let attempt = bench.start(Body::Sequence(vec![step(0, "on")]));
    desk.commands.recv().unwrap();
    desk.answers.send(refused(RefusedKind::Taken, "task 9 has it")).unwrap();
    let exit = bench.exit(attempt);
    assert_eq!(exit, Exit::Failed("step 1 (camera on): task 9 has it".into()));
}

#[test]
fn a_device_without_a_response_fails_the_step_at_its_declared_time() {
    let (mut bench, desk) = bench(Some(Duration::from_millis(5)));
    let attempt = bench.start(Body::Sequence(vec![step(0, "on")]));
    desk.commands.recv().unwrap();
    let why = "step 1 (camera on): no response within its declared time";
    assert_eq!(bench.exit(attempt), Exit::Failed(why.into()));
    // The late answer is nobody's.
    desk.answers.send(done()).unwrap();
    let next = bench.start_for(Body::Hold, Duration::ZERO);
    assert_eq!(bench.exit(next), Exit::Code(0));
    assert_eq!(bench.told(), []);
}

#[test]
fn a_sequence_whose_device_hangs_runs_away_when_it_is_killed() {
    let (mut bench, desk) = bench(None);
    let attempt = bench.start(Body::Sequence(vec![step(0, "on"), step(0, "off")]));
    desk.commands.recv().unwrap();
    bench.stop(attempt, Stop::Kill { grace: Duration::from_millis(1) });
    bench.wait(|event| (*event == Event::Runaway { attempt }).then_some(()));
    desk.answers.send(done()).unwrap();
    assert_eq!(bench.exit(attempt), Exit::Signal(15));
    assert!(desk.commands.is_empty(), "it went on after its end");
}

#[test]
fn an_empty_sequence_and_an_idle_one_end_at_once() {
    let (mut bench, _desk) = bench(None);
    let empty = bench.start(Body::Sequence(vec![]));
    assert_eq!(bench.exit(empty), Exit::Code(0));
    let idle = bench.start(Body::Sequence(vec![step(1_000_000, "on")]));
    assert_eq!(bench.kill(idle, Duration::from_secs(1)), Exit::Signal(15));
}

#[test]
fn a_hold_takes_its_running_time() {
    let mut bench = Bench::new(Settings::default());
    let duration = Duration::from_millis(30);
    let begun = bench.now().elapsed;
    let attempt = bench.start_for(Body::Hold, duration);
    bench.pause(attempt);
    assert_eq!(bench.bodies.next_due(), None);
    super::look::real_time(std::time::Duration::from_millis(60));
    let resumed = bench.now().elapsed;
    bench.resume(attempt);
    let due = bench.bodies.next_due().unwrap();
    assert!(due > resumed, "the pause counted");
    assert_eq!(bench.exit(attempt), Exit::Code(0));
    assert!(bench.now().elapsed.since(begun) >= Duration::from_millis(90));
    let other = bench.start_for(Body::Hold, Duration::from_secs(1000));
    assert_eq!(bench.kill(other, Duration::from_secs(1000)), Exit::Signal(15));
}
