//! Wake-ups over a Linux `eventfd`.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use faregate_tickets::clock::{Clock, Instant};
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};
use rustix::io::{Errno, read, write};

use super::Woken;
use crate::clock::MonotonicClock;

/// A bell that any thread may ring and one thread at a time waits for.
///
/// The bell remembers: a notification that comes before the wait ends the next
/// wait at once, so none is lost between looking for work and going to sleep.
/// It does not count: notifications that nobody took meanwhile are one. Where
/// two threads wait, one of them takes it.
///
/// Everything written before a notification is visible after the wait that it
/// ended.
///
/// The descriptor is readable while a notification is waiting to be taken: an
/// event loop of the mission's own may watch it.
#[derive(Debug)]
pub struct Wakeup {
    bell: OwnedFd,
    clock: MonotonicClock,
}

impl Wakeup {
    /// A bell that has not been rung.
    ///
    /// # Errors
    /// When the host has no file descriptor left.
    pub fn new() -> io::Result<Self> {
        let bell = eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)?;
        Ok(Self { bell, clock: MonotonicClock::new() })
    }

    /// Ends the wait, or the next one if nobody waits.
    ///
    /// # Timing
    /// One system call, which never blocks. Not for inside a critical section.
    pub fn notify(&self) {
        let rung = write(&self.bell, &1_u64.to_ne_bytes());
        // A full counter refuses the addition, but is rung already.
        debug_assert!(matches!(rung, Ok(8) | Err(Errno::AGAIN)), "{rung:?}");
    }

    /// Sleeps until somebody notifies, or until `deadline` by the
    /// [`MonotonicClock`]; without one as long as it takes. A notification
    /// that is there already wins over a deadline that has passed.
    ///
    /// Never returns [`Woken::Deadline`] early. It is late by the host's timer
    /// slack (none for threads with a real-time priority) and by the time for
    /// which more important threads keep the CPU.
    ///
    /// # Errors
    /// When the kernel cannot wait, which takes a process whose limit of open
    /// files was lowered to none, or a kernel without memory.
    pub fn wait_until(&self, deadline: Option<Instant>) -> io::Result<Woken> {
        loop {
            let came = self.sleep(deadline);
            if self.take()? {
                return Ok(Woken::Notified);
            }
            match came {
                // A signal, or another waiter that took the notification.
                Ok(()) | Err(Errno::INTR) => {}
                Err(errno) => return Err(errno.into()),
            }
            if deadline.is_some_and(|deadline| self.clock.now() >= deadline) {
                return Ok(Woken::Deadline);
            }
        }
    }

    /// Sleeps until the bell may have been rung or the deadline may have come.
    fn sleep(&self, deadline: Option<Instant>) -> Result<(), Errno> {
        // Both instants are rounded down, so the difference is never too short.
        let timeout = deadline.map(|deadline| timespec(deadline.since(self.clock.now()).into()));
        poll(&mut [PollFd::new(&self.bell, PollFlags::IN)], timeout.as_ref()).map(drop)
    }

    /// Takes the notification, if there is one.
    fn take(&self) -> Result<bool, Errno> {
        match read(&self.bell, &mut [0_u8; 8]) {
            Ok(_) => Ok(true),
            Err(Errno::AGAIN) => Ok(false),
            Err(errno) => Err(errno),
        }
    }
}

impl AsFd for Wakeup {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.bell.as_fd()
    }
}

/// A timeout for the kernel. What does not fit is centuries away: the wait
/// wakes then, looks at the clock and goes on.
fn timespec(timeout: core::time::Duration) -> Timespec {
    Timespec {
        tv_sec: timeout.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: timeout.subsec_nanos().into(),
    }
}
