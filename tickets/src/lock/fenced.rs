//! Gates whose tenant enters with loads, stores and one fence.

use core::marker::PhantomData;

use super::sys::Excludes;
use super::sys::fenced::{FencedLock, FencedWay};
use super::{Exclusion, Owner, Shut, Strategy, Task, Way};
use crate::clock::Duration;
use crate::ticket::Seat;

/// The tenant announces that it is inside, looks whether it may be, and is:
/// loads, stores and one fence. Everybody else enters by `S`, turns the tenant
/// away at its next command, and waits, by `W`, until the present one is over.
///
/// A ticket's first command goes by `S` too, and so does the first after
/// somebody else was inside; the ones after it take the short way. A gate has
/// [`SHORT_WAYS`](FencedLock::SHORT_WAYS) of them, which tickets keep from their
/// first command to their first refusal. Where all are taken, by as many
/// tickets whose holders were pre-empted and have not noticed yet, the next
/// one's commands go by `S`.
///
/// For holders that are not pre-empted inside a command: who waits for one on
/// the short way lends it no priority. A driver that invokes *another* ticket
/// of its own gate on the short way is told [`Shut::TimedOut`] after the gate's
/// patience, not at once.
///
/// # Timing
/// Short way: a few loads and stores and one fence; no loop, no
/// read-modify-write. Else that of `S`, and of the command in flight; a timeout
/// counts for each of the two.
#[derive(Debug)]
pub struct Fenced<S, W>(PhantomData<fn() -> (S, W)>);

/// How a waiter passes the time until a command in flight is over.
pub trait Wait: 'static {
    /// Waits until `over` says so; answers `false` if `timeout` passed before.
    ///
    /// Called where waiting is right only because the command in flight runs
    /// on another core: a spin, with a yield where there is one. Who waits looks
    /// once more when this has answered, and enters only if it is over.
    #[must_use]
    fn until(timeout: Duration, over: impl FnMut() -> bool) -> bool;
}

impl<S: Excludes, W: Wait> Strategy for Fenced<S, W> {
    type Lock<T: Send> = FencedLock<T, S, W>;
}

impl<T: Send, S: Excludes, W: Wait> Exclusion<T> for FencedLock<T, S, W> {
    type Way<'l>
        = FencedWay<'l, T, S, W>
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, patience: Duration) -> FencedWay<'l, T, S, W> {
        FencedWay::new(self, patience)
    }

    fn new(value: T) -> Self {
        Self::new(value)
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.outer.with(|()| self.drained(Duration::MAX, f))?
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.outer.try_with(|()| self.drained(Duration::ZERO, f))?.map_err(|_| Shut::Busy)
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        self.outer
            .with_until(timeout, |(), owner| self.drained(timeout, |value| f(value, owner)))?
    }
}

impl<T: Send, S: Excludes, W: Wait> FencedWay<'_, T, S, W> {
    // Apart: what the short way does not need is not in its way.
    #[cold]
    #[inline(never)]
    fn with_outer<St, E, J: Task<T, St>>(
        &self,
        look: impl Fn() -> Result<St, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        let lock = self.lock;
        lock.outer.with(|()| {
            lock.drained(self.patience, |value| look().map(|seen| self.first(value, seen, task)))
        })?
    }
}

impl<T: Send, S: Excludes, W: Wait> Way<T> for FencedWay<'_, T, S, W> {
    fn with<St, E, J: Task<T, St>>(
        &self,
        look: impl Fn() -> Result<St, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        match self.enter()? {
            Some(inside) => Ok(inside.run(|value| look().map(|seen| task.run(value, seen).0))),
            None => self.with_outer(look, task),
        }
    }

    fn try_with<St, E, J: Task<T, St>>(
        &self,
        look: impl Fn() -> Result<St, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        if let Some(inside) = self.enter()? {
            return Ok(inside.run(|value| look().map(|seen| task.run(value, seen).0)));
        }
        let lock = self.lock;
        let entered = lock.outer.try_with(|()| {
            lock.drained(Duration::ZERO, |value| look().map(|seen| self.first(value, seen, task)))
        })?;
        entered.map_err(|_| Shut::Busy)
    }

    fn step_back(&self) {
        self.give_up();
    }
}
