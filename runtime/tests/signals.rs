//! Wake-ups under signals. Alone in its file, because handlers are of the whole
//! process.
#![cfg(target_os = "linux")]

use std::os::unix::thread::JoinHandleExt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::thread;

use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::wake::{Wakeup, Woken};
use faregate_tickets::clock::{Clock, Duration};

/// How many signals were handled.
static HANDLED: AtomicU32 = AtomicU32::new(0);

mod sys {
    #![expect(unsafe_code, reason = "std has no signals")]

    use std::os::unix::thread::RawPthread;
    use std::sync::atomic::Ordering::Relaxed;

    extern "C" fn count(_: libc::c_int) {
        super::HANDLED.fetch_add(1, Relaxed);
    }

    pub(super) fn count_signals() {
        let handler: extern "C" fn(libc::c_int) = count;
        // SAFETY: the handler does no more than an atomic addition.
        let before = unsafe { libc::signal(libc::SIGUSR1, handler as libc::sighandler_t) };
        assert_ne!(before, libc::SIG_ERR);
    }

    pub(super) fn signal(thread: RawPthread) {
        // SAFETY: the caller has not joined the thread, so its id is alive.
        assert_eq!(unsafe { libc::pthread_kill(thread, libc::SIGUSR1) }, 0);
    }
}

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
