//! The bell that wakes the manager's thread.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;

use rustix::event::{EventfdFlags, eventfd};
use rustix::io::{Errno, read, write};

/// Wakes the manager's thread, from any thread.
///
/// One bell is shared by all ports. It remembers: a ring that comes before the
/// wait ends the next wait at once. It does not count: who was woken asks every
/// port what happened.
#[derive(Clone, Debug)]
pub struct Waker(Arc<OwnedFd>);

impl Waker {
    /// A bell that has not been rung.
    ///
    /// # Errors
    /// When the host has no file descriptor left.
    pub fn new() -> io::Result<Self> {
        let bell = eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)?;
        Ok(Self(Arc::new(bell)))
    }

    /// Ends the wait, or the next one. What was written before is visible to
    /// who is woken.
    ///
    /// # Timing
    /// One system call, which never blocks.
    pub fn wake(&self) {
        let rung = write(&*self.0, &1_u64.to_ne_bytes());
        // A full counter refuses the addition, but is rung already.
        debug_assert!(matches!(rung, Ok(8) | Err(Errno::AGAIN)), "{rung:?}");
    }

    /// Takes the ring: whether there was one. To be called *before* the ports
    /// are asked, or a ring between is lost.
    #[must_use = "a ring that was taken is not there any more"]
    pub fn take(&self) -> bool {
        let mut rings = [0; 8];
        matches!(read(&*self.0, &mut rings), Ok(8))
    }
}

/// Readable while a ring waits to be taken.
impl AsFd for Waker {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    use super::*;

    fn is_rung(waker: &Waker) -> bool {
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        poll(&mut [PollFd::new(waker, PollFlags::IN)], Some(&at_once)).unwrap() > 0
    }

    #[test]
    fn a_ring_is_remembered_until_it_is_taken_and_not_counted() {
        let waker = Waker::new().unwrap();
        assert!(!is_rung(&waker) && !waker.take());
        let other = waker.clone();
        std::thread::spawn(move || {
            other.wake();
            other.wake();
        })
        .join()
        .unwrap();
        assert!(is_rung(&waker));
        assert!(waker.take());
        assert!(!is_rung(&waker) && !waker.take());
    }
}
