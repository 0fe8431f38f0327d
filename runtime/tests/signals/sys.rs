//! What the test of signals asks of the operating system.
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
