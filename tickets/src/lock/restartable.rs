//! Gates whose tenant's command is one store, which a revocation calls back.

use core::cell::Cell;
use core::fmt;
use core::marker::PhantomData;
use core::sync::atomic::AtomicU32;

use super::{Exclusion, Next, Owner, Shut, Strategy, Task, Way};
use crate::clock::Duration;
use crate::sync::{AtomicUsize, Ordering};
use crate::ticket::Seat;

/// A command that is one store is checked and stored in one *section*, which
/// starts again from its check if its thread is disturbed in it. Everybody
/// enters by `S`; who is not the tenant then ends all sections, by `K`, and
/// waits for nobody: not for a tenant that was pre-empted before its store, which
/// will find itself revoked.
///
/// A ticket's first command goes by `S`, and so does the first after somebody
/// else was inside; if it is left as [`Next::Store`], the ones after it are
/// sections.
///
/// # Timing
/// A section: four words compared, one store; started again at most
/// three times, then by `S`. Who comes by `S`: that of `S`,
/// and `K`'s system call if a tenant's stores were in order since.
#[derive(Debug)]
pub struct Restartable<S, K>(PhantomData<fn() -> (S, K)>);

/// What a section compares before it stores.
#[derive(Clone, Copy, Debug)]
pub struct Watch<'a> {
    pub(crate) words: [&'a AtomicUsize; 4],
    pub(crate) values: [usize; 4],
}

impl Watch<'_> {
    /// Whether every word has the value that is expected.
    ///
    /// # Timing
    /// Constant: four loads.
    #[must_use]
    pub fn is_as_expected(&self) -> bool {
        let [a, b, c, d] = self.words.map(|word| word.load(Ordering::Relaxed));
        [a, b, c, d] == self.values
    }
}

/// How a section ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// All words were as expected, and the store was done.
    Stored,
    /// A word was not as expected.
    Refused,
    /// The thread was disturbed before the store.
    Restarted,
}

/// The sections of a platform.
pub trait Sections: 'static {
    /// Compares, and stores if all words are as expected: at once, as far as
    /// [`end_all`](Sections::end_all) is concerned.
    ///
    /// # Timing
    /// Constant: no loop, no read-modify-write.
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome;

    /// Ends the sections in progress: each has stored, or will compare again
    /// and see everything that was written before this call. Answers `false`
    /// if that cannot be had.
    ///
    /// # Timing
    /// One system call, which waits for no thread.
    #[must_use]
    fn end_all() -> bool;
}

impl<S: Strategy, K: Sections> Strategy for Restartable<S, K> {
    type Lock<T: Send> = RestartableLock<S::Lock<T>, K>;
}

/// The lock behind [`Restartable`].
pub struct RestartableLock<L, K> {
    inner: L,
    /// The way on which stores are in order; 0: none. Written inside `inner`
    /// only, so every access there is Relaxed.
    open_to: AtomicUsize,
    /// How many ways there have been.
    ways: AtomicUsize,
    sections: PhantomData<fn() -> K>,
}

/// On no way are stores in order.
const CLOSED: usize = 0;

impl<L, K> fmt::Debug for RestartableLock<L, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RestartableLock").field("open_to", &self.open_to).finish_non_exhaustive()
    }
}

impl<L, K: Sections> RestartableLock<L, K> {
    /// From here on no store is in order, and none is in progress. The caller
    /// is inside `inner`.
    fn close(&self) -> Result<(), Shut> {
        let open = self.open_to.load(Ordering::Relaxed);
        if open == CLOSED {
            return Ok(());
        }
        // Relaxed: `end_all` orders it before every comparison that comes.
        self.open_to.store(CLOSED, Ordering::Relaxed);
        if cfg!(feature = "mutant-sections-go-on") || K::end_all() {
            return Ok(());
        }
        self.open_to.store(open, Ordering::Relaxed);
        Err(Shut::TimedOut)
    }
}

impl<T: Send, L: Exclusion<T>, K: Sections> Exclusion<T> for RestartableLock<L, K> {
    type Way<'l>
        = RestartableWay<'l, L, K>
    where
        Self: 'l;

    fn way<'l>(&'l self, seat: &Seat<'l>, _: Duration) -> RestartableWay<'l, L, K> {
        // Relaxed: only that no two are the same.
        let before = self.ways.fetch_add(1, Ordering::Relaxed);
        RestartableWay {
            lock: self,
            number: before.wrapping_add(1),
            epochs: [seat.standing.word(), seat.agent.word(), seat.broker.word()],
            seen: Cell::new([0; 3]),
        }
    }

    fn new(value: T) -> Self {
        Self {
            inner: L::new(value),
            open_to: AtomicUsize::new(CLOSED),
            ways: AtomicUsize::new(0),
            sections: PhantomData,
        }
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.inner.with(|value| self.close().map(|()| f(value)))?
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.inner.try_with(|value| self.close().map(|()| f(value)))?
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        self.inner.with_until(timeout, |value, owner| self.close().map(|()| f(value, owner)))?
    }
}

/// A ticket's way into a [`RestartableLock`].
pub struct RestartableWay<'l, L, K> {
    lock: &'l RestartableLock<L, K>,
    /// This way's number in `open_to`.
    number: usize,
    /// The ticket's, the agent's, the broker's.
    epochs: [&'l AtomicUsize; 3],
    /// What they were when the ticket was last found valid inside. The cell
    /// keeps the way from being shared between threads.
    seen: Cell<[usize; 3]>,
}

impl<L, K> fmt::Debug for RestartableWay<'_, L, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RestartableWay").field("number", &self.number).finish_non_exhaustive()
    }
}

impl<L, K: Sections> RestartableWay<'_, L, K> {
    /// How often a section is started before the command goes by `S`.
    pub const TRIES: usize = 3;

    #[inline(always)]
    fn section(&self, register: &AtomicU32, word: u32) -> Outcome {
        let [own, agent, broker] = self.epochs;
        let [own_seen, agent_seen, broker_seen] = self.seen.get();
        let watch = Watch {
            words: [&self.lock.open_to, own, agent, broker],
            values: [self.number, own_seen, agent_seen, broker_seen],
        };
        K::store(&watch, register, word)
    }

    // Apart: a section in a loop keeps its dozen words on the stack.
    #[cold]
    #[inline(never)]
    fn store_again(&self, register: &AtomicU32, word: u32) -> bool {
        for _ in 1..Self::TRIES {
            match self.section(register, word) {
                Outcome::Stored => return true,
                Outcome::Refused => return false,
                Outcome::Restarted => {}
            }
        }
        false
    }

    /// Inside `inner`.
    fn enter<T, St, E, J: Task<T, St>>(
        &self,
        value: &mut T,
        look: impl Fn() -> Result<St, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        // On its own way no section is in progress: its holder is here.
        if self.lock.open_to.load(Ordering::Relaxed) != self.number {
            self.lock.close()?;
        }
        // Before the look, which then is about these epochs or later ones.
        let epochs = self.epochs.map(|epoch| epoch.load(Ordering::Relaxed));
        Ok(look().map(|seen| {
            // Should the task unwind, or come back to its ticket, no store is
            // in order.
            self.lock.open_to.store(CLOSED, Ordering::Relaxed);
            let (result, next) = task.run(value, seen);
            self.seen.set(epochs);
            let open = if next == Next::Store { self.number } else { CLOSED };
            // Relaxed: whom it concerns reads it after this, in program order.
            self.lock.open_to.store(open, Ordering::Relaxed);
            result
        }))
    }
}

impl<T: Send, L: Exclusion<T>, K: Sections> Way<T> for RestartableWay<'_, L, K> {
    fn with<St, E, J: Task<T, St>>(
        &self,
        look: impl Fn() -> Result<St, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        self.lock.inner.with(|value| self.enter(value, look, task))?
    }

    fn try_with<St, E, J: Task<T, St>>(
        &self,
        look: impl Fn() -> Result<St, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        self.lock.inner.try_with(|value| self.enter(value, look, task))?
    }

    fn step_back(&self) {
        // No epoch: they begin with 1.
        self.seen.set([0; 3]);
    }

    #[inline]
    fn store(&self, register: &AtomicU32, word: u32) -> bool {
        match self.section(register, word) {
            Outcome::Stored => true,
            Outcome::Refused => false,
            Outcome::Restarted => self.store_again(register, word),
        }
    }
}
