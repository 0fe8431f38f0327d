//! Gates behind a priority-inheriting lock.

use core::marker::PhantomData;

use super::sys::pi::{self as sys, CurrentThread, PiMutex};
use super::{Exclusion, Owner, Shut, Strategy};
use crate::clock::Duration;
use crate::ticket::Seat;

/// Who waits lends its priority to who is inside: the Linux futex.
///
/// `I` says which thread is running. Two things go beyond the contract of
/// [`Exclusion`]: entering is also [`Shut::Reentered`] where the thread inside
/// waits, through other such locks, for the calling one (two threads that wait
/// for each other would wait for ever); and an owner's death is noticed by
/// whoever waits for the dead: to [`try_with`](Exclusion::try_with) alone the
/// lock stays [`Shut::Busy`].
///
/// A thread that dies *inside* without unwinding is known by its id. Should the
/// kernel give that id to a new thread before anybody waits, the new one counts
/// as inside.
///
/// # Timing
/// Uncontended: one compare-exchange to enter, one to leave; no loop, no system
/// call. Contended: one system call to wait (again after a signal), and one of
/// the owner's to hand over. `try_with` makes no system call where it does not enter.
#[derive(Debug)]
pub struct PiLocked<I>(PhantomData<fn() -> I>);

impl<I> PiLocked<I> {
    /// Whether this kernel has priority-inheriting futexes. Ask at start-up:
    /// where it has none, the first contended critical section panics.
    #[must_use]
    pub fn is_supported() -> bool {
        sys::is_supported()
    }
}

impl<I: CurrentThread> Strategy for PiLocked<I> {
    type Lock<T: Send> = PiMutex<T, I>;
}

impl<T: Send, I: CurrentThread> Exclusion<T> for PiMutex<T, I> {
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self::new(value)
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        let mut inside = self.enter(None)?;
        match inside.owner() {
            Owner::Sound => Ok(f(&mut inside)),
            Owner::Died => Err(Shut::OwnerDied),
        }
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        let mut inside = self.try_enter()?;
        match inside.owner() {
            Owner::Sound => Ok(f(&mut inside)),
            Owner::Died => Err(Shut::OwnerDied),
        }
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        let mut inside = self.enter(Some(timeout))?;
        let owner = inside.owner();
        Ok(f(&mut inside, owner))
    }
}
