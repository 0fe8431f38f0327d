//! Gate strategies: how one critical section at a time is entered.
//!
//! | strategy | where |
//! |---|---|
//! | `PiLocked` | Linux, mixed priorities; the default of `faregate-runtime` there |
//! | `Locked` | plain hosts (`parking_lot`), anything with a `lock_api::RawMutex` |
//! | `Masked` | one core without an operating system |
//! | `LoomLocked` | under the model checker |

use crate::clock::Duration;

#[cfg(feature = "lock-api")]
mod locked;
#[cfg(loom)]
mod loomed;
#[cfg(feature = "critical-section")]
mod masked;
#[cfg(all(feature = "linux", target_os = "linux", not(loom)))]
mod pi;
#[cfg(all(feature = "linux", target_os = "linux", not(loom)))]
mod sys;

#[cfg(feature = "lock-api")]
pub use locked::Locked;
#[cfg(loom)]
pub use loomed::LoomLocked;
#[cfg(feature = "critical-section")]
pub use masked::Masked;
#[cfg(all(feature = "linux", target_os = "linux", not(loom)))]
pub use {pi::PiLocked, sys::CurrentThread};

/// A way to exclude others from a critical section, chosen at compile time.
pub trait Strategy: 'static {
    /// The lock that guards a `T`.
    type Lock<T: Send>: Exclusion<T> + Send + Sync;
}

/// A lock around a value, entered with a closure.
///
/// If the closure unwinds the lock is left, not poisoned: what a torn state
/// means is the business of whoever put the state inside.
pub trait Exclusion<T> {
    /// Puts the value behind the lock.
    fn new(value: T) -> Self
    where
        Self: Sized;

    /// Runs `f` alone with the value, waiting as long as it takes.
    ///
    /// # Errors
    /// [`Shut::Reentered`] when this thread is inside already;
    /// [`Shut::OwnerDied`] when a thread died inside (reported to each caller
    /// from then on: the value may be torn).
    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut>;

    /// Runs `f` alone with the value, or says [`Shut::Busy`] at once.
    ///
    /// # Errors
    /// As [`with`](Exclusion::with), and [`Shut::Busy`].
    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut>;

    /// Runs `f` alone with the value, waiting at most `timeout`. Unlike the
    /// others it enters after an owner's death too, and tells `f` of it, so
    /// that the agent's safing still passes.
    ///
    /// # Errors
    /// [`Shut::Reentered`], or [`Shut::TimedOut`].
    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut>;
}

/// Why a critical section was not entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shut {
    /// Somebody else is inside, and the caller did not want to wait.
    Busy,
    /// Somebody else was inside for the whole time that the caller would wait.
    TimedOut,
    /// The calling thread itself is inside.
    Reentered,
    /// A thread died inside.
    OwnerDied,
}

/// Whether a thread died inside before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Owner {
    /// No.
    Sound,
    /// Yes: the value may be torn.
    Died,
}
