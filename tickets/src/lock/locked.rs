//! Gates behind any `lock_api` mutex.

use core::fmt;
use core::marker::PhantomData;
use core::num::NonZeroUsize;

use lock_api::{GetThreadId, Mutex, RawMutexTimed};

use super::{Exclusion, Owner, Shut, Strategy};
use crate::clock::Duration;
use crate::sync::{AtomicUsize, Ordering};
use crate::ticket::Seat;

/// The mutex `R`, for threads that `I` tells apart.
///
/// With `parking_lot` on plain hosts: `Locked<parking_lot::RawMutex,
/// parking_lot::RawThreadId>`. Who waits lends nobody its priority. What a
/// timeout is measured by is `R`'s choice; a simulator brings a virtual clock.
///
/// A thread that dies inside without unwinding leaves the lock shut: nobody
/// hears of [`Shut::OwnerDied`].
///
/// # Timing
/// That of `R`, and two stores. `parking_lot` may allocate when a thread waits
/// for the first time.
#[derive(Debug)]
pub struct Locked<R, I>(PhantomData<fn() -> (R, I)>);

impl<R, I> Strategy for Locked<R, I>
where
    R: RawMutexTimed<Duration = core::time::Duration> + Send + Sync + 'static,
    I: GetThreadId + Send + Sync + 'static,
{
    type Lock<T: Send> = OwnedMutex<R, I, T>;
}

/// A mutex that knows who is inside.
pub struct OwnedMutex<R, I, T> {
    mutex: Mutex<R, T>,
    /// The id of the thread inside, or `NOBODY`.
    ///
    /// Relaxed is enough: a thread asks only whether its *own* id is here. Only
    /// it writes that id, and it writes `NOBODY` before it leaves; of its own
    /// stores it sees the last one or a later store of another thread.
    owner: AtomicUsize,
    threads: I,
}

/// No thread's id: those are not zero.
const NOBODY: usize = 0;

impl<R, I, T> fmt::Debug for OwnedMutex<R, I, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnedMutex").field("owner", &self.owner).finish_non_exhaustive()
    }
}

impl<R, I, T> OwnedMutex<R, I, T>
where
    R: RawMutexTimed<Duration = core::time::Duration>,
    I: GetThreadId,
{
    fn caller(&self) -> Result<NonZeroUsize, Shut> {
        let caller = self.threads.nonzero_thread_id();
        if self.owner.load(Ordering::Relaxed) == caller.get() {
            Err(Shut::Reentered)
        } else {
            Ok(caller)
        }
    }

    /// Notes who is inside, for as long as `f` runs or unwinds.
    fn note<Out>(&self, caller: NonZeroUsize, f: impl FnOnce() -> Out) -> Out {
        let _noted = Noted::new(&self.owner, caller);
        f()
    }
}

/// The owner's note: written when it enters, taken back when it leaves.
struct Noted<'a>(&'a AtomicUsize);

impl<'a> Noted<'a> {
    fn new(owner: &'a AtomicUsize, caller: NonZeroUsize) -> Self {
        owner.store(caller.get(), Ordering::Relaxed);
        Self(owner)
    }
}

impl Drop for Noted<'_> {
    fn drop(&mut self) {
        self.0.store(NOBODY, Ordering::Relaxed);
    }
}

impl<R, I, T: Send> Exclusion<T> for OwnedMutex<R, I, T>
where
    R: RawMutexTimed<Duration = core::time::Duration> + Sync,
    I: GetThreadId + Sync,
{
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self { mutex: Mutex::new(value), owner: AtomicUsize::new(NOBODY), threads: I::INIT }
    }

    fn with<Out>(&self, f: impl FnOnce(&mut T) -> Out) -> Result<Out, Shut> {
        let caller = self.caller()?;
        let mut value = self.mutex.lock();
        Ok(self.note(caller, || f(&mut value)))
    }

    fn try_with<Out>(&self, f: impl FnOnce(&mut T) -> Out) -> Result<Out, Shut> {
        let caller = self.caller()?;
        let mut value = self.mutex.try_lock().ok_or(Shut::Busy)?;
        Ok(self.note(caller, || f(&mut value)))
    }

    fn with_until<Out>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> Out,
    ) -> Result<Out, Shut> {
        let caller = self.caller()?;
        let mut value = self.mutex.try_lock_for(timeout.into()).ok_or(Shut::TimedOut)?;
        Ok(self.note(caller, || f(&mut value, Owner::Sound)))
    }
}
