//! How a model is run, and how its threads are made.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use loom::thread::{Builder, JoinHandle};

/// Explores `model` up to three pre-emptions; see [`explore_to`].
pub(crate) fn explore(name: &str, floor: usize, model: impl Fn() + Send + Sync + 'static) {
    explore_to(3, name, floor, model);
}

/// Explores `model` up to so many pre-emptions, unless `LOOM_MAX_PREEMPTIONS`
/// says otherwise; prints how many executions that were, and wants at least
/// `floor` of them.
pub(crate) fn explore_to(
    preemptions: usize,
    name: &str,
    floor: usize,
    model: impl Fn() + Send + Sync + 'static,
) {
    let executions = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&executions);
    let model = Arc::new(model);
    let mut builder = loom::model::Builder::new();
    builder.max_branches = 20_000;
    builder.preemption_bound = builder.preemption_bound.or(Some(preemptions));
    builder.check(move || {
        counted.fetch_add(1, Ordering::Relaxed);
        let model = Arc::clone(&model);
        // The first thread of an execution has a stack of 32 KiB.
        join(spawn(move || model()));
    });
    let executions = executions.load(Ordering::Relaxed);
    println!("model {name}: {executions} executions");
    assert!(executions >= floor, "{name} has only {executions} executions, expected {floor}");
}

/// A thread with room for the books on its stack.
pub(crate) fn spawn<R: Send + 'static>(f: impl FnOnce() -> R + Send + 'static) -> JoinHandle<R> {
    // In words, of which only those touched are ever mapped.
    const STACK: usize = 1 << 17;
    Builder::new().stack_size(STACK).spawn(f).expect("loom has room for five threads")
}

/// What the thread answers.
pub(crate) fn join<R: 'static>(thread: JoinHandle<R>) -> R {
    thread.join().expect("the thread comes to its end")
}

/// Keeps the value for the rest of the process: gates borrow, and threads
/// outlive what they borrow from.
pub(crate) fn keep<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}
