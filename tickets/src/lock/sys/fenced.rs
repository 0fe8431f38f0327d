//! The lock whose tenant enters without it.
//!
//! | word | who writes | meaning |
//! |---|---|---|
//! | `open_to` | who is inside `outer` | which short way is open; 0: none |
//! | `unseen` | who is inside `outer` | which short way nobody has seen to be empty since it was open; 0: none |
//! | `in_flight` of a short way | its ticket's holder | grows; odd: inside, or looking whether it may be |
//! | `taken` of a short way | set inside `outer`, cleared by its ticket's holder | some ticket has it |
//!
//! *Announce, then look.* The holder makes its word odd and then reads
//! `open_to`; who comes by `outer` clears `open_to` and then reads the word.
//! Each has a `SeqCst` fence between the two, and the fences have an order: if
//! the holder's is the later one it finds its way closed; if the other's is,
//! that one finds the word odd, and waits until it *changes*. (To wait until it
//! is even would be to wait for a holder that hammers a closed way.)
//!
//! Which way to wait at is a word of its own, that is cleared when the wait has
//! come to its end and not before. So who gives up, unwinds or dies in the wait
//! leaves the next one to wait at the same way.
//!
//! *One Inside.* One thread at a time reaches the value: who is inside `outer`
//! and has closed the open way and seen its word change or even; or the holder
//! of the open way, between its announcement and its exit. Only one way is open
//! at a time, each way is one ticket's, and a ticket is not shared between
//! threads.

use core::cell::Cell;
use core::fmt;
use core::marker::PhantomData;

use super::super::{Exclusion, Shut, Strategy, Task, Wait};
use super::Excludes;
use crate::clock::Duration;
use crate::sync::{AtomicUsize, Ordering, SHORT_WAYS, UnsafeCell, fence};

/// The lock behind [`Fenced`](crate::lock::Fenced).
pub struct FencedLock<T, S: Strategy, W> {
    pub(in crate::lock) outer: S::Lock<()>,
    open_to: AtomicUsize,
    unseen: AtomicUsize,
    ways: [ShortWay; SHORT_WAYS],
    value: UnsafeCell<T>,
    wait: PhantomData<fn() -> W>,
}

/// A cache line of its own: the tenant writes it at every command.
#[repr(align(64))]
#[derive(Debug)]
struct ShortWay {
    in_flight: AtomicUsize,
    taken: AtomicUsize,
}

/// No short way is open.
const CLOSED: usize = 0;

// SAFETY: the value is reached inside `drained` and `Inside::run` alone, which
// by One Inside one thread does at a time; `T: Send` lets it be a different one
// each time. `S::Lock<()>` is `Sync`, and so is the rest.
unsafe impl<T: Send, S: Excludes, W> Sync for FencedLock<T, S, W> {}

impl<T, S: Strategy, W> fmt::Debug for FencedLock<T, S, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FencedLock").field("open_to", &self.open_to).finish_non_exhaustive()
    }
}

impl<T, S: Strategy, W> FencedLock<T, S, W> {
    /// How many tickets of one gate can have a short way at the same time.
    pub const SHORT_WAYS: usize = SHORT_WAYS;
}

impl<T, S: Excludes, W: Wait> FencedLock<T, S, W> {
    pub(in crate::lock) fn new(value: T) -> Self {
        Self {
            outer: Exclusion::new(()),
            open_to: AtomicUsize::new(CLOSED),
            unseen: AtomicUsize::new(CLOSED),
            ways: core::array::from_fn(|_| ShortWay {
                in_flight: AtomicUsize::new(0),
                taken: AtomicUsize::new(0),
            }),
            value: UnsafeCell::new(value),
            wait: PhantomData,
        }
    }

    /// Runs `f` when the short way that was open is closed and empty. The
    /// caller is inside `outer`.
    pub(in crate::lock) fn drained<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T) -> R,
    ) -> Result<R, Shut> {
        // Relaxed: written inside `outer` only.
        let open = self.open_to.load(Ordering::Relaxed);
        self.open_to.store(CLOSED, Ordering::Relaxed);
        // Pairs with the fence in `enter`.
        fence(Ordering::SeqCst);
        if !self.see_empty(timeout) {
            // Open as before: nobody was inside meanwhile.
            self.open_to.store(open, Ordering::Relaxed);
            return Err(Shut::TimedOut);
        }
        // SAFETY: by One Inside nobody else reaches the value now.
        Ok(self.value.with_mut(|value| f(unsafe { &mut *value })))
    }

    /// Waits until what the way that was open announced is over.
    fn see_empty(&self, timeout: Duration) -> bool {
        // Relaxed, here and below: read and written inside `outer` only.
        let unseen = self.unseen.load(Ordering::Relaxed);
        let Some(way) = self.ways.get(unseen.wrapping_sub(1)) else { return true };
        // Acquire: pairs with the Release of the exit, or of the next entry,
        // which comes after that exit.
        let seen = way.in_flight.load(Ordering::Acquire);
        let changed = || way.in_flight.load(Ordering::Acquire) != seen;
        // Looked at again, whatever `until` says: `Wait` is a safe trait.
        let empty = seen % 2 == 0 || W::until(timeout, changed) && changed();
        if empty {
            self.unseen.store(CLOSED, Ordering::Relaxed);
        }
        empty
    }
}

/// A ticket's way into a [`FencedLock`].
pub struct FencedWay<'l, T, S: Excludes, W: Wait> {
    pub(in crate::lock) lock: &'l FencedLock<T, S, W>,
    pub(in crate::lock) patience: Duration,
    /// The number of the short way that is this ticket's, from 1; 0: none. The
    /// cell keeps the way from being shared between threads.
    number: Cell<usize>,
}

impl<T, S: Excludes, W: Wait> fmt::Debug for FencedWay<'_, T, S, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FencedWay").field("number", &self.number).finish_non_exhaustive()
    }
}

impl<'l, T, S: Excludes, W: Wait> FencedWay<'l, T, S, W> {
    pub(in crate::lock) fn new(lock: &'l FencedLock<T, S, W>, patience: Duration) -> Self {
        Self { lock, patience, number: Cell::new(CLOSED) }
    }

    /// Enters by the short way, if this ticket's is the open one.
    pub(in crate::lock) fn enter(&self) -> Result<Option<Inside<'l, T>>, Shut> {
        let number = self.number.get();
        let Some(way) = self.lock.ways.get(number.wrapping_sub(1)) else { return Ok(None) };
        #[cfg(feature = "mutant-look-before-announcing")]
        let open = self.lock.open_to.load(Ordering::Relaxed);
        // Relaxed: written by this ticket's holder only.
        let count = way.in_flight.load(Ordering::Relaxed);
        if count % 2 == 1 {
            // The driver that runs here invokes the ticket that it was reached by.
            return Err(Shut::Reentered);
        }
        // Release: who waits for the entry before this one may see this one
        // instead of that one's exit.
        #[cfg(not(feature = "mutant-relaxed-entry"))]
        way.in_flight.store(count.wrapping_add(1), Ordering::Release);
        #[cfg(feature = "mutant-relaxed-entry")]
        way.in_flight.store(count.wrapping_add(1), Ordering::Relaxed);
        let exit = Exit { word: &way.in_flight, after: count.wrapping_add(2) };
        // Pairs with the fence in `drained`.
        #[cfg(not(feature = "mutant-unfenced"))]
        fence(Ordering::SeqCst);
        // Relaxed: only the fences order it. What somebody else did inside was
        // seen by the entry through `outer` that opened this way since.
        #[cfg(not(feature = "mutant-look-before-announcing"))]
        let open = self.lock.open_to.load(Ordering::Relaxed);
        Ok((open == number).then_some(Inside { exit, value: &self.lock.value }))
    }

    /// Does the task of a ticket that came in through `outer`, and opens its short
    /// way. The caller is inside `drained`.
    pub(in crate::lock) fn first<St, J: Task<T, St>>(
        &self,
        value: &mut T,
        seen: St,
        task: J,
    ) -> J::Output {
        // Should it unwind, no way is open.
        let (result, _) = task.run(value, seen);
        if self.number.get() == CLOSED {
            self.number.set(self.lock.claim());
        }
        self.lock.unseen.store(self.number.get(), Ordering::Relaxed);
        // Relaxed: whom it concerns reads it after this, in program order.
        self.lock.open_to.store(self.number.get(), Ordering::Relaxed);
        result
    }

    /// Gives the short way up, for other tickets.
    pub(in crate::lock) fn give_up(&self) {
        let number = self.number.replace(CLOSED);
        if let Some(way) = self.lock.ways.get(number.wrapping_sub(1)) {
            // Release: pairs with the Acquire in `claim`. Should the way be
            // open still, nobody announces anything on it.
            way.taken.store(0, Ordering::Release);
        }
    }
}

impl<T, S: Strategy, W> FencedLock<T, S, W> {
    /// A short way that no ticket has, or `CLOSED`. The caller is inside
    /// `outer`, so nobody else claims.
    fn claim(&self) -> usize {
        for (number, way) in (1..).zip(&self.ways) {
            // Acquire: the count goes on where the last ticket left it.
            if way.taken.load(Ordering::Acquire) == 0 {
                way.taken.store(1, Ordering::Relaxed);
                return number;
            }
        }
        CLOSED
    }
}

impl<T, S: Excludes, W: Wait> Drop for FencedWay<'_, T, S, W> {
    fn drop(&mut self) {
        self.give_up();
    }
}

/// Being inside by the short way.
pub(in crate::lock) struct Inside<'l, T> {
    exit: Exit<'l>,
    value: &'l UnsafeCell<T>,
}

impl<T> Inside<'_, T> {
    pub(in crate::lock) fn run<R>(self, f: impl FnOnce(&mut T) -> R) -> R {
        let Self { exit, value } = self;
        // SAFETY: by One Inside nobody else reaches the value before `exit` is
        // dropped, which is after `f`.
        let result = value.with_mut(|value| f(unsafe { &mut *value }));
        drop(exit);
        result
    }
}

/// The announcement; dropping it is the exit, unwinding included.
struct Exit<'l> {
    word: &'l AtomicUsize,
    after: usize,
}

impl Drop for Exit<'_> {
    fn drop(&mut self) {
        // Release: pairs with the Acquire in `see_empty`; Empty Room rests on it.
        #[cfg(not(feature = "mutant-relaxed-exit"))]
        self.word.store(self.after, Ordering::Release);
        #[cfg(feature = "mutant-relaxed-exit")]
        self.word.store(self.after, Ordering::Relaxed);
    }
}
