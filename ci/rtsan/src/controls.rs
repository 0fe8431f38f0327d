//! What the sanitizer must report, each for one reason.

use std::hint::black_box;
use std::sync::Mutex;
use std::thread;
use std::time::Duration;

use faregate_runtime::host::HostStrategy;
use faregate_tickets::id::Priority;

use crate::bench::{Bench, Outcome, Switch};

#[sanitize(realtime = "nonblocking")]
pub(crate) fn allocate() {
    black_box(Box::new(black_box(1)));
}

#[sanitize(realtime = "nonblocking")]
pub(crate) fn free(boxed: Box<u32>) {
    drop(black_box(boxed));
}

pub(crate) fn lock() {
    let lock = Mutex::new(());
    let held = lock.lock();
    thread::scope(|scope| {
        scope.spawn(|| wait_for(&lock));
        thread::sleep(Duration::from_millis(200));
        drop(held);
    });
}

#[sanitize(realtime = "nonblocking")]
fn wait_for(lock: &Mutex<()>) {
    drop(lock.lock());
}

/// The one system call of a gate that is contended.
pub(crate) fn contend() -> Outcome<()> {
    let bench = Bench::<HostStrategy>::new()?;
    let ticket = bench.broker.request(Priority::SCIENCE, &bench.lamp)?;
    bench.broker.service();
    let id = ticket.id();
    thread::scope(|scope| {
        scope.spawn(move || ticket.invoke(Switch::Sleep(Duration::from_millis(500))).is_ok());
        thread::sleep(Duration::from_millis(100));
        bar_and_quiesce(&bench, id)
    })
}

#[sanitize(realtime = "nonblocking")]
fn bar_and_quiesce(
    bench: &Bench<HostStrategy>,
    ticket: faregate_tickets::id::TicketId,
) -> Outcome<()> {
    bench.broker.bar(&bench.supervisor, ticket)?.quiesce()?;
    Ok(())
}
