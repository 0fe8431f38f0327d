//! A lock whose waiting is a switch point and takes virtual time.

use std::fmt;
use std::ptr;
use std::sync::atomic::{AtomicUsize, Ordering};

use faregate_tickets::clock::Duration;
use faregate_tickets::lock::{Exclusion, Owner, Shut, Strategy};
use faregate_tickets::ticket::Seat;
use parking_lot::{Mutex, MutexGuard};

use super::body::{self, block};
use super::core::{self, Cause};

/// The gate strategy of a simulated campaign: critical sections behind a
/// [`SimLock`].
#[derive(Clone, Copy, Debug)]
pub struct SimLocked;

impl Strategy for SimLocked {
    type Lock<T: Send> = SimLock<T>;
}

/// A lock that waits in the interleaver: while one body is inside, even asleep
/// inside, others run up to the door. A deadline is virtual time.
///
/// Outside an interleaver it is an ordinary lock, for real threads. The two
/// kinds do not mix on one lock.
pub struct SimLock<T> {
    value: Mutex<T>,
    /// The [identity](core::current_id) of who is inside, or 0. A body looks for
    /// its own number only, which nobody else writes, so Relaxed is enough.
    holder: AtomicUsize,
}

impl<T> SimLock<T> {
    fn address(&self) -> usize {
        ptr::from_ref(self).addr()
    }

    fn check_reentry(&self) -> Result<(), Shut> {
        if self.holder.load(Ordering::Relaxed) == core::current_id() {
            Err(Shut::Reentered)
        } else {
            Ok(())
        }
    }

    fn try_enter(&self) -> Option<Inside<'_, T>> {
        let value = self.value.try_lock()?;
        Some(self.entered(value))
    }

    fn entered<'a>(&'a self, value: MutexGuard<'a, T>) -> Inside<'a, T> {
        self.holder.store(core::current_id(), Ordering::Relaxed);
        Inside { lock: self, value: Some(value) }
    }

    /// Waits at the door, for as long as it takes.
    fn enter(&self) -> Inside<'_, T> {
        if !body::is_running() {
            return self.entered(self.value.lock());
        }
        loop {
            if let Some(inside) = self.try_enter() {
                return inside;
            }
            self.wait(faregate_tickets::clock::Instant::FAR_FUTURE);
        }
    }

    /// Waits at the door, no longer than this.
    fn enter_within(&self, timeout: Duration) -> Option<Inside<'_, T>> {
        if !body::is_running() {
            return Some(self.entered(self.value.try_lock_for(timeout.into())?));
        }
        let deadline = body::now().after(timeout);
        loop {
            if let Some(inside) = self.try_enter() {
                return Some(inside);
            }
            if body::now() >= deadline {
                return None;
            }
            self.wait(deadline);
        }
    }

    fn wait(&self, until: faregate_tickets::clock::Instant) {
        let holder = self.holder.load(Ordering::Relaxed);
        // Whatever ended the wait, the caller looks at the lock again.
        let _ = block(Cause::Lock { lock: self.address(), holder }, until);
    }
}

impl<T: Send> Exclusion<T> for SimLock<T> {
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self { value: Mutex::new(value), holder: AtomicUsize::new(0) }
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.check_reentry()?;
        body::switch_point("lock");
        let answer = self.enter().run(f);
        body::switch_point("unlocked");
        Ok(answer)
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.check_reentry()?;
        body::switch_point("try_lock");
        let answer = self.try_enter().ok_or(Shut::Busy)?.run(f);
        body::switch_point("unlocked");
        Ok(answer)
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        self.check_reentry()?;
        body::switch_point("lock");
        // A body that dies inside unwinds and leaves the lock, so no owner is
        // ever found dead here.
        let answer =
            self.enter_within(timeout).ok_or(Shut::TimedOut)?.run(|value| f(value, Owner::Sound));
        body::switch_point("unlocked");
        Ok(answer)
    }
}

/// The way out: leaves the lock and wakes those who wait, unwinding included.
struct Inside<'a, T> {
    lock: &'a SimLock<T>,
    value: Option<MutexGuard<'a, T>>,
}

impl<T> Inside<'_, T> {
    fn run<R>(mut self, f: impl FnOnce(&mut T) -> R) -> R {
        f(self.value.as_mut().expect("only drop takes the value"))
    }
}

impl<T> Drop for Inside<'_, T> {
    fn drop(&mut self) {
        self.lock.holder.store(0, Ordering::Relaxed);
        self.value = None;
        core::with(|core| core.unlocked(self.lock.address()));
    }
}

impl<T> fmt::Debug for SimLock<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SimLock").field("locked", &self.value.is_locked()).finish()
    }
}
