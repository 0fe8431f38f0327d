//! What the threads of a command port share: every order in which they can
//! meet, and every value that memory may show them.
#![cfg(loom)]

#[path = "port/sys.rs"]
mod sys;

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use faregate_scheduler_models::beat::Beat;
use faregate_scheduler_models::entrance::{Entrance, Quiet};
use loom::cell::UnsafeCell;
use loom::sync::atomic::{AtomicBool, Ordering};
use sys::{read, write};

/// Explores, prints how many executions that were, and wants at least `floor`:
/// a model that explores nothing looks green.
fn explore(name: &str, floor: usize, model: impl Fn() + Send + Sync + 'static) {
    let executions = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&executions);
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = builder.preemption_bound.or(Some(3));
    builder.check(move || {
        counted.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        model();
    });
    let executions = executions.load(std::sync::atomic::Ordering::Relaxed);
    println!("model {name}: {executions} executions");
    assert!(executions >= floor, "{name} has only {executions} executions, expected {floor}");
}

/// The bell of the manager's thread: remembers a ring until it is taken.
#[derive(Debug)]
struct Bell(AtomicBool);

impl Bell {
    fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    fn ring(&self) {
        // As the kernel's counter: one order of rings and takings.
        self.0.swap(true, Ordering::AcqRel);
    }

    fn take(&self) -> bool {
        self.0.swap(false, Ordering::AcqRel)
    }
}

/// An attempt, its workers, and the tickets that the next attempt will have.
struct Attempt {
    entrance: Entrance,
    bell: Bell,
    /// Which attempt the tickets are for. Loom finds out who looks while
    /// another one writes.
    tickets: UnsafeCell<u32>,
}

impl Attempt {
    fn new() -> Arc<Self> {
        Arc::new(Self { entrance: Entrance::new(), bell: Bell::new(), tickets: UnsafeCell::new(1) })
    }

    /// Issues a command, as a worker does.
    fn command(&self) {
        let Some(inside) = self.entrance.enter() else { return };
        let of = self.tickets.with(|of| read(of));
        assert_eq!(of, 1, "Shut Entrance: a command was issued under the next attempt's tickets");
        if inside.leave() == Quiet::Now {
            self.bell.ring();
        }
    }

    /// The next attempt begins.
    fn begin_next(&self) {
        self.tickets.with_mut(|of| write(of, 2));
    }
}

/// With so many workers inside, out, and turned away.
fn shut_entrance_with(workers: usize) {
    let attempt = Attempt::new();
    let workers: Vec<_> = (0..workers)
        .map(|_| Arc::clone(&attempt))
        .map(|attempt| loom::thread::spawn(move || attempt.command()))
        .collect();
    let quiet = attempt.entrance.close() == Quiet::Now || {
        // The manager's thread looks when it is rung, and only then.
        attempt.bell.take() && attempt.entrance.quiet() == Quiet::Now
    };
    if quiet {
        attempt.begin_next();
    }
    workers.into_iter().for_each(|worker| worker.join().unwrap());
    if !quiet {
        assert!(attempt.bell.take(), "Shut Entrance: nobody told that the last one has left");
        assert_eq!(attempt.entrance.quiet(), Quiet::Now);
        attempt.begin_next();
    }
    attempt.command();
}

#[test]
fn shut_entrance() {
    explore("shut_entrance", 9, || shut_entrance_with(1));
}

#[test]
fn shut_entrance_for_two() {
    explore("shut_entrance_for_two", 400, || shut_entrance_with(2));
}

#[test]
fn no_lost_beat() {
    explore("no_lost_beat", 13, || {
        let shared = Arc::new((Beat::new(), Bell::new()));
        let beats = Arc::clone(&shared);
        let task = loom::thread::spawn(move || {
            for _ in 0..2 {
                beats.0.beat(|| beats.1.ring());
            }
        });
        let (beat, bell) = &*shared;
        // The manager's thread, woken or not, and then asleep.
        let mut heard = 0;
        for _ in 0..2 {
            if bell.take() && beat.take() {
                heard += 1;
            }
        }
        task.join().unwrap();
        let waits = bell.take();
        let left = beat.take();
        assert!(!left || waits, "No Lost Beat: a beat waits, and nobody was rung for it");
        assert!(heard > 0 || left, "No Lost Beat: no beat was told");
    });
}
