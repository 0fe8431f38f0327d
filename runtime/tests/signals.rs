//! Wake-ups under signals. Alone in its file, because handlers are of the whole
//! process.
#![cfg(target_os = "linux")]

#[path = "signals/sys.rs"]
mod sys;

use std::os::unix::thread::JoinHandleExt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::thread;

use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::wake::{Wakeup, Woken};
use faregate_tickets::clock::{Clock, Duration};

/// How many signals were handled.
static HANDLED: AtomicU32 = AtomicU32::new(0);

#[test]
fn a_signal_neither_ends_a_wait_nor_moves_its_deadline() {
    sys::count_signals();
    let clock = MonotonicClock::new();
    let deadline = clock.now().after(Duration::from_millis(200));
    let bell = Arc::new(Wakeup::new().unwrap());
    let waiting = Arc::clone(&bell);
    let waiter = thread::spawn(move || {
        (waiting.wait_until(Some(deadline)).unwrap(), MonotonicClock::new().now())
    });
    let pause = Wakeup::new().unwrap();
    for ms in 1..=10 {
        let until = clock.now().after(Duration::from_millis(ms));
        assert_eq!(pause.wait_until(Some(until)).unwrap(), Woken::Deadline);
        sys::signal(waiter.as_pthread_t());
    }
    let (woken, at) = waiter.join().unwrap();
    assert_eq!(woken, Woken::Deadline);
    assert!(at >= deadline, "{at} is before {deadline}");
    assert!(HANDLED.load(Relaxed) > 0);
}
