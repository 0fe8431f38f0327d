//! Gate strategies: how one critical section at a time is entered.
//!
//! | strategy | where |
//! |---|---|
//! | `PiLocked` | Linux, mixed priorities; the default of `faregate-runtime` there |
//! | `Locked` | plain hosts (`parking_lot`), anything with a `lock_api::RawMutex` |
//! | `Masked` | one core without an operating system |
//! | [`Fenced`] | several cores, and holders that nobody pre-empts inside a command |
//! | [`Restartable`] | Linux, commands that are one store |
//! | `LoomLocked` | under the model checker |
//!
//! The last two but one stand on one of the others, which is how everybody
//! enters but the tenant. The tenant's tickets have a [`Way`] of their own.

use core::sync::atomic::AtomicU32;

use crate::clock::Duration;
use crate::ticket::Seat;

mod fenced;
mod restartable;

#[cfg(feature = "lock-api")]
mod locked;
#[cfg(loom)]
mod loomed;
#[cfg(feature = "critical-section")]
mod masked;
#[cfg(all(feature = "linux", target_os = "linux", not(loom)))]
mod pi;
mod sys;

pub use fenced::{Fenced, Wait};
#[cfg(feature = "lock-api")]
pub use locked::Locked;
#[cfg(loom)]
pub use loomed::{LoomLocked, LoomSections, LoomWait};
#[cfg(feature = "critical-section")]
pub use masked::Masked;
pub use restartable::{Outcome, Restartable, Sections, Watch};
#[cfg(all(
    feature = "linux",
    target_os = "linux",
    any(target_arch = "x86_64", target_arch = "aarch64"),
    not(loom)
))]
pub use sys::rseq::{Registered, Rseq};
pub use sys::{Excludes, fenced::FencedLock};
#[cfg(all(feature = "linux", target_os = "linux", not(loom)))]
pub use {pi::PiLocked, sys::pi::CurrentThread};

/// A way to exclude others from a critical section, chosen at compile time.
pub trait Strategy: 'static {
    /// The lock that guards a `T`.
    type Lock<T: Send>: Exclusion<T> + Send + Sync;
}

/// A lock around a value, entered with a closure.
///
/// If the closure unwinds the lock is left, not poisoned: what a torn state
/// means is the business of whoever put the state inside.
pub trait Exclusion<T: Send>: Sync {
    /// A ticket's own way in; `&Self` where it is everybody's.
    type Way<'l>: Way<T> + Send
    where
        Self: 'l;

    /// Makes a way in for the ticket with this seat, which its holder alone
    /// takes. Who waits on it for somebody that the strategy cannot tell from
    /// the caller waits no longer than `patience`.
    fn way<'l>(&'l self, seat: &Seat<'l>, patience: Duration) -> Self::Way<'l>;

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

/// A ticket's own way into a lock.
pub trait Way<T> {
    /// Does `task` alone with the value, if `look`, made inside, agrees; what
    /// it answered goes to the task.
    ///
    /// # Errors
    /// As [`Exclusion::with`]; where the strategy cannot tell re-entry,
    /// [`Shut::TimedOut`] instead. The inner error is what `look` said.
    fn with<S, E, J: Task<T, S>>(
        &self,
        look: impl Fn() -> Result<S, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut>;

    /// Like [`with`](Way::with), or says [`Shut::Busy`] at once.
    ///
    /// # Errors
    /// As [`with`](Way::with), and [`Shut::Busy`].
    fn try_with<S, E, J: Task<T, S>>(
        &self,
        look: impl Fn() -> Result<S, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut>;

    /// Stores `word` in `register` if nobody entered and nothing was revoked
    /// since the way was left as [`Next::Store`]; answers whether it did.
    ///
    /// # Timing
    /// Constant; nothing at all where the strategy has no such way.
    fn store(&self, register: &AtomicU32, word: u32) -> bool {
        let _ = (register, word);
        false
    }

    /// The ticket was refused: what the way keeps for its next entry is free
    /// for others.
    fn step_back(&self) {}
}

/// What is done inside.
///
/// A trait instead of a closure, because a closure cannot be told to be inlined
/// always. A strategy that calls it in two places would hand it over in memory.
pub trait Task<T, S> {
    /// What comes of it.
    type Output;

    /// Does it, after `seen` was seen inside; says how the way is left.
    fn run(self, value: &mut T, seen: S) -> (Self::Output, Next);
}

impl<T, S, R, F: FnOnce(&mut T, S) -> (R, Next)> Task<T, S> for F {
    type Output = R;

    fn run(self, value: &mut T, seen: S) -> (R, Next) {
        self(value, seen)
    }
}

/// How a [`Way`] is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Next {
    /// The ticket's next command comes in as this one did, or faster.
    Enter,
    /// Besides, a command that is one store needs nobody's leave until
    /// somebody else enters.
    Store,
}

/// The way of everybody.
impl<T: Send, L: Exclusion<T> + ?Sized> Way<T> for &L {
    fn with<S, E, J: Task<T, S>>(
        &self,
        look: impl Fn() -> Result<S, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        (**self).with(|value| look().map(|seen| task.run(value, seen).0))
    }

    fn try_with<S, E, J: Task<T, S>>(
        &self,
        look: impl Fn() -> Result<S, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        (**self).try_with(|value| look().map(|seen| task.run(value, seen).0))
    }
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
