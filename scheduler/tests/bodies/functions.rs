//! Functions as tasks: how they end, how they are asked to.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{ThreadId, current};

use crossbeam::channel::{Receiver, Sender, bounded};
use faregate_scheduler::bodies::{
    Functions, Invocation, Moment, NotRegistered, Probe, Settings, Surroundings,
};
use faregate_scheduler::manager::{Attempt, Event, Exit, Stop};
use faregate_scheduler::task::{Body, CheckpointSignal};
use faregate_scheduler::time::Duration;

use super::bench::Bench;

const NUMBER: u16 = 16;

fn bench_with(
    settings: Settings,
    function: impl Fn(&Invocation) -> Result<(), String> + Send + Sync + 'static,
) -> Bench {
    let mut functions = Functions::new();
    functions.register(NUMBER, function).unwrap();
    Bench::around(settings, Surroundings { functions, ..Surroundings::default() })
}

fn body(arguments: &[&str]) -> Body {
    let arguments = arguments.iter().map(ToString::to_string).collect();
    Body::Function { number: NUMBER, arguments }
}

const fn checkpoint(grace: Duration) -> Stop {
    Stop::Checkpoint { grace, signal: CheckpointSignal::User1 }
}

#[test]
fn a_function_ends_as_it_answers() {
    let mut bench = bench_with(Settings::default(), |call| match call.arguments() {
        [] => Ok(()),
        [why] => Err(why.clone()),
        [.., last] => panic!("{last}"),
    });
    let good = bench.start(body(&[]));
    assert_eq!(bench.exit(good), Exit::Code(0));
    let bad = bench.start(body(&["no film"]));
    assert_eq!(bench.exit(bad), Exit::Failed("no film".into()));
    let ugly = bench.start(body(&["a", "jammed"]));
    assert_eq!(bench.exit(ugly), Exit::Panicked("jammed".into()));
    // The panic was the task's, not the worker's.
    let again = bench.start(body(&[]));
    assert_eq!(bench.exit(again), Exit::Code(0));
}

#[test]
fn a_panic_that_panics_again_when_it_is_dropped_ends_there() {
    struct Twice;
    impl Drop for Twice {
        fn drop(&mut self) {
            panic!("again");
        }
    }
    let mut bench = bench_with(Settings::default(), |_| std::panic::panic_any(Twice));
    let attempt = bench.start(body(&[]));
    assert_eq!(bench.exit(attempt), Exit::Panicked("it panicked without words".into()));
}

#[test]
fn what_is_not_registered_is_not_started() {
    let mut bench = Bench::new(Settings::default());
    let attempt = bench.start(body(&[]));
    let exit = bench.exit(attempt);
    assert_eq!(exit, Exit::NotStarted("no function is registered for type 16".into()));
}

#[test]
fn a_number_has_one_function_and_the_managers_own_are_not_free() {
    let mut functions = Functions::new();
    assert_eq!(functions.register(15, |_| Ok(())), Err(NotRegistered::Reserved(15)));
    assert_eq!(functions.register(16, |_| Ok(())), Ok(()));
    assert_eq!(functions.register(16, |_| Ok(())), Err(NotRegistered::Used(16)));
    assert_eq!(functions.numbers().collect::<Vec<_>>(), [16]);
}

#[test]
fn a_function_that_heeds_the_question_ends_within_its_grace() {
    let mut bench = bench_with(Settings::default(), |call| {
        call.heartbeat();
        let asked = call.asked_to_stop_within(Duration::from_secs(1000));
        if asked && call.asked_to_stop() { Err("saved".into()) } else { Ok(()) }
    });
    let attempt = bench.start(body(&[]));
    bench.wait(|event| (*event == Event::Heartbeat { attempt }).then_some(()));
    bench.stop(attempt, checkpoint(Duration::from_secs(1000)));
    assert_eq!(bench.exit(attempt), Exit::Failed("saved".into()));
    assert_eq!(bench.told(), []);
}

#[test]
fn heartbeats_of_a_function_are_one_event_however_many_they_were() {
    let (beaten, has_beaten) = bounded(0);
    let mut bench = bench_with(Settings::default(), move |call| {
        (0..10_000).for_each(|_| call.heartbeat());
        beaten.send(()).map_err(|_| "the test is over".to_owned())?;
        let _ = call.asked_to_stop_within(Duration::from_secs(1000));
        Ok(())
    });
    let attempt = bench.start(body(&[]));
    has_beaten.recv().unwrap();
    for _ in 0..2 {
        bench.bodies_poll();
        assert_eq!(bench.told(), [Event::Heartbeat { attempt }]);
    }
    bench.stop(attempt, checkpoint(Duration::from_secs(1000)));
    assert_eq!(bench.exit(attempt), Exit::Code(0));
}

/// A function that returns when it is let, whatever it is asked.
fn deaf(settings: Settings) -> (Bench, Sender<()>, Arc<AtomicUsize>) {
    let (let_go, gate): (Sender<()>, Receiver<()>) = bounded(0);
    let entered = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&entered);
    let bench = bench_with(settings, move |_| {
        count.fetch_add(1, Ordering::SeqCst);
        gate.recv().map_err(|_| "the test is over".to_owned())
    });
    (bench, let_go, entered)
}

#[test]
fn a_function_that_outstays_its_grace_is_runaway_and_exits_when_it_returns() {
    let (mut bench, let_go, _) = deaf(Settings::default());
    let attempt = bench.start(body(&[]));
    bench.stop(attempt, checkpoint(Duration::from_millis(1)));
    bench.wait(|event| (*event == Event::Runaway { attempt }).then_some(()));
    let_go.send(()).unwrap();
    assert_eq!(bench.exit(attempt), Exit::Code(0));
    assert_eq!(bench.told(), [], "runaway is told once");
}

#[test]
fn the_worker_of_a_runaway_is_not_used_again_and_others_go_on() {
    let threads: Arc<Mutex<BTreeMap<Attempt, ThreadId>>> = Arc::default();
    let seen = Arc::clone(&threads);
    let probe = Probe::new(move |moment, attempt| {
        assert_eq!(moment, Moment::Enter);
        seen.lock().unwrap().insert(attempt, current().id());
    });
    let settings = Settings { probe, workers_ready: 1, ..Settings::default() };
    let (mut bench, let_go, _) = deaf(settings);
    let lost = bench.start(body(&[]));
    bench.stop(lost, checkpoint(Duration::ZERO));
    bench.wait(|event| (*event == Event::Runaway { attempt: lost }).then_some(()));
    let next = bench.start(body(&[]));
    let_go.send(()).unwrap();
    let_go.send(()).unwrap();
    assert_eq!((bench.exit(lost), bench.exit(next)), (Exit::Code(0), Exit::Code(0)));
    let both = [bench.start(body(&[])), bench.start(body(&[]))];
    let_go.send(()).unwrap();
    let_go.send(()).unwrap();
    assert_eq!(both.map(|attempt| bench.exit(attempt)), [Exit::Code(0), Exit::Code(0)]);
    let threads = threads.lock().unwrap();
    let later = both.map(|attempt| threads[&attempt]);
    assert!(!later.contains(&threads[&lost]), "the lost worker was used again");
    assert!(later.contains(&threads[&next]), "the idle worker was not used");
}

#[test]
fn a_function_without_a_worker_is_not_started_and_does_not_wait() {
    let settings = Settings { workers: 1, ..Settings::default() };
    let (mut bench, let_go, entered) = deaf(settings);
    let first = bench.start(body(&[]));
    let second = bench.start(body(&[]));
    assert_eq!(bench.exit(second), Exit::NotStarted("all 1 workers are busy".into()));
    let_go.send(()).unwrap();
    assert_eq!(bench.exit(first), Exit::Code(0));
    assert_eq!(entered.load(Ordering::SeqCst), 1);
}
