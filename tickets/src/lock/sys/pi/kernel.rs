//! The system calls of the lock.

use core::ptr;
use core::sync::atomic::AtomicU32;

use libc::{clockid_t, timespec};

use crate::clock::Duration;

/// How to wait: the futex operation, and its absolute deadline.
pub(super) struct Way {
    pub(super) operation: libc::c_int,
    pub(super) deadline: Option<timespec>,
}

impl Way {
    pub(super) const FOREVER: Self = Self { operation: libc::FUTEX_LOCK_PI, deadline: None };

    /// `FUTEX_LOCK_PI` reads its deadline on the wall clock, `FUTEX_LOCK_PI2`
    /// on the monotonic one.
    pub(super) fn until(timeout: Duration, clock: clockid_t) -> Self {
        let operation = match clock {
            libc::CLOCK_MONOTONIC => libc::FUTEX_LOCK_PI2,
            _ => libc::FUTEX_LOCK_PI,
        };
        Self { operation, deadline: Some(later(now(clock), timeout)) }
    }

    /// The way on kernels without `FUTEX_LOCK_PI2`: there the wall clock, when
    /// it is set, moves the deadline.
    pub(super) fn before_linux_5_14(&self, timeout: Option<Duration>, errno: libc::c_int) -> Self {
        match timeout {
            Some(timeout) if errno == libc::ENOSYS && self.operation == libc::FUTEX_LOCK_PI2 => {
                Self::until(timeout, libc::CLOCK_REALTIME)
            }
            _ => defect("wait", errno),
        }
    }
}

/// The kernel's other answers are to ids that are no thread's, or to words that
/// somebody scribbled over.
#[expect(clippy::unreachable, reason = "a kernel that breaks its promise, when contended")]
pub(super) fn defect(what: &str, errno: libc::c_int) -> ! {
    unreachable!("the futex of a gate failed to {what}: errno {errno}")
}

/// `start` and `timeout` together, or the latest instant that there is.
fn later(start: timespec, timeout: Duration) -> timespec {
    let timeout = core::time::Duration::from(timeout);
    let whole = libc::time_t::try_from(timeout.as_secs()).unwrap_or(libc::time_t::MAX);
    // Below a second each: their sum fits even in 32 bits.
    let nanos = start.tv_nsec + libc::c_long::from(timeout.subsec_nanos().cast_signed());
    let carry = nanos / 1_000_000_000;
    timespec {
        tv_sec: start.tv_sec.saturating_add(whole).saturating_add(carry),
        tv_nsec: nanos - carry * 1_000_000_000,
    }
}

fn now(clock: clockid_t) -> timespec {
    let mut now = timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `now` is writable. The call cannot fail: both clocks exist on
    // every Linux.
    unsafe { libc::clock_gettime(clock, &raw mut now) };
    now
}

// What `SYS_futex` reads is the kernel's timespec: two longs.
const _: () = assert!(size_of::<timespec>() == 2 * size_of::<libc::c_long>());

/// Performs one futex operation; answers 0 or the error number.
pub(super) fn futex(
    word: &AtomicU32,
    operation: libc::c_int,
    deadline: Option<&timespec>,
) -> libc::c_int {
    let operation = operation | libc::FUTEX_PRIVATE_FLAG;
    let deadline = deadline.map_or(ptr::null(), ptr::from_ref);
    // SAFETY: `word` is an aligned `u32` that others change atomically only,
    // `deadline` is null or readable, both for the whole call; the operations
    // used here take no other argument.
    let answer = unsafe { libc::syscall(libc::SYS_futex, word.as_ptr(), operation, 0, deadline) };
    if answer == 0 {
        return 0;
    }
    // SAFETY: asks nothing of its caller.
    let errno = unsafe { libc::__errno_location() };
    // SAFETY: each thread has an error number, which lives as long as it does.
    unsafe { *errno }
}
