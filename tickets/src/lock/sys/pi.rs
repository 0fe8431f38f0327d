//! The priority-inheriting lock: a futex word, and the value that it guards.
//!
//! | the word's bits | who sets them | meaning |
//! |---|---|---|
//! | 0 to 29, the owner's id | the owner; the kernel, when it hands over | who is inside; 0: nobody |
//! | 30, `OWNER_DIED` | the kernel, or who found the owner dead | the value may be torn |
//! | 31, `WAITERS` | the kernel | only the kernel can hand over |
//!
//! *One Inside*: a thread is inside from the moment its own id came into the
//! word, by its own exchange from `FREE` or by the kernel, until it gives the
//! word up. No other thread takes a living owner's id out of the word.

mod kernel;

use core::cell::UnsafeCell;
use core::fmt;
use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use self::kernel::{Way, defect, futex};
use super::super::{Owner, Shut};
use crate::clock::Duration;

/// Nobody is inside, nobody waits.
const FREE: u32 = 0;
const OWNER: u32 = libc::FUTEX_TID_MASK;
const OWNER_DIED: u32 = libc::FUTEX_OWNER_DIED;
const WAITERS: u32 = libc::FUTEX_WAITERS;

/// Says which thread is running, by the kernel's own number for it.
///
/// # Safety
/// [`tid`](CurrentThread::tid) answers what `gettid` would: the kernel takes
/// the number for the thread that it boosts, and the lock takes two threads
/// with different numbers for two threads. A cached number is stale in the
/// child of a `fork`.
pub unsafe trait CurrentThread: 'static {
    /// The calling thread's id.
    ///
    /// # Timing
    /// Called once for each critical section: cache it in a thread local.
    fn tid() -> u32;
}

/// The lock behind [`PiLocked`](crate::lock::PiLocked).
pub struct PiMutex<T, I> {
    word: AtomicU32,
    /// Whether a thread died inside. Read and written only inside, so every
    /// access to it is Relaxed.
    died: AtomicBool,
    value: UnsafeCell<T>,
    threads: PhantomData<fn() -> I>,
}

// SAFETY: the value is reached through `Inside` alone, which by One Inside one
// thread has at a time; `T: Send` lets it be a different one each time.
unsafe impl<T: Send, I> Sync for PiMutex<T, I> {}

impl<T, I> fmt::Debug for PiMutex<T, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PiMutex").field("word", &self.word).finish_non_exhaustive()
    }
}

impl<T, I: CurrentThread> PiMutex<T, I> {
    pub(in crate::lock) const fn new(value: T) -> Self {
        Self {
            word: AtomicU32::new(FREE),
            died: AtomicBool::new(false),
            value: UnsafeCell::new(value),
            threads: PhantomData,
        }
    }

    /// Enters, or says [`Shut::Busy`] or [`Shut::Reentered`] at once.
    pub(in crate::lock) fn try_enter(&self) -> Result<Inside<'_, T, I>, Shut> {
        let tid = I::tid();
        // Acquire pairs with the Release in `Inside::drop`. A refusal reads
        // nothing but the word: its own id is there only if it put it there.
        match self.word.compare_exchange(FREE, tid, Ordering::Acquire, Ordering::Relaxed) {
            Ok(_) => Ok(Inside::of(self, tid)),
            Err(word) if word & OWNER == tid => Err(Shut::Reentered),
            Err(_) => Err(Shut::Busy),
        }
    }

    /// Enters; waits for that at most `timeout`, or as long as it takes.
    pub(in crate::lock) fn enter(
        &self,
        timeout: Option<Duration>,
    ) -> Result<Inside<'_, T, I>, Shut> {
        match self.try_enter() {
            Err(Shut::Busy) => self.wait(timeout).map(|()| Inside::of(self, I::tid())),
            entered_or_reentered => entered_or_reentered,
        }
    }

    /// Lets the kernel put this thread's id into the word, and meanwhile lend
    /// its priority to the owner.
    ///
    /// The kernel's own locks order what the last owner did before what this
    /// one does, and to the compiler a system call may read and write it all.
    #[cold]
    #[inline(never)]
    fn wait(&self, timeout: Option<Duration>) -> Result<(), Shut> {
        let mut way =
            timeout.map_or(Way::FOREVER, |timeout| Way::until(timeout, libc::CLOCK_MONOTONIC));
        loop {
            match futex(&self.word, way.operation, way.deadline.as_ref()) {
                0 => {
                    self.note_if_owner_died();
                    return Ok(());
                }
                libc::ETIMEDOUT => return Err(Shut::TimedOut),
                // The owner waits, through other such locks, for this thread.
                libc::EDEADLK => return Err(Shut::Reentered),
                // No such thread; or its heir was chosen and has not run yet,
                // which the kernel calls inconsistent until the word says it.
                libc::ESRCH | libc::EINVAL => self.mark_if_owner_died(),
                // The word changed under the kernel, a signal came, or memory
                // was short: none of them lasts.
                libc::EAGAIN | libc::EINTR | libc::ENOMEM => {}
                errno => way = way.before_linux_5_14(timeout, errno),
            }
        }
    }

    /// Notes, inside, what the kernel says in the word it handed over. The bit
    /// goes when the word is left, the note stays.
    fn note_if_owner_died(&self) {
        if self.word.load(Ordering::Relaxed) & OWNER_DIED != 0 {
            self.died.store(true, Ordering::Relaxed);
        }
    }

    /// Replaces the owner's id by `OWNER_DIED` if that thread is dead: what the
    /// kernel does for a robust list. A waiter of the dead owner stays its heir.
    ///
    /// The death is asked for by the id read here, on a word of our own. That
    /// [`wait`](Self::wait) was told of a dead owner is no proof: in the
    /// meantime a living one may have come into the word. The dead do not
    /// return, so an id that is dead and still in the word has been there all
    /// the time. (Until the kernel counts its thread ids round.)
    fn mark_if_owner_died(&self) {
        let word = self.word.load(Ordering::Relaxed);
        let question = AtomicU32::new(word & OWNER);
        if futex(&question, libc::FUTEX_TRYLOCK_PI, None) == libc::ESRCH {
            let marked = word & WAITERS | OWNER_DIED;
            // Orders nothing: a dead owner published nothing. If it fails,
            // somebody else marked it or is the heir.
            let _ = self.word.compare_exchange(word, marked, Ordering::Relaxed, Ordering::Relaxed);
        }
    }

    /// Lets the kernel give the word to the most important waiter.
    #[cold]
    #[inline(never)]
    fn hand_over(&self) {
        loop {
            match futex(&self.word, libc::FUTEX_UNLOCK_PI, None) {
                0 => return,
                // A waiter was changing the word.
                libc::EAGAIN | libc::EINTR => {}
                errno => defect("leave", errno),
            }
        }
    }
}

/// Whether this kernel has priority-inheriting futexes.
pub(in crate::lock) fn is_supported() -> bool {
    futex(&AtomicU32::new(FREE), libc::FUTEX_TRYLOCK_PI, None) == 0
}

/// Being inside; dropping it leaves. Only the thread that entered can leave, so
/// it is not `Send`.
pub(in crate::lock) struct Inside<'a, T, I: CurrentThread> {
    lock: &'a PiMutex<T, I>,
    tid: u32,
    stays: PhantomData<*const ()>,
}

impl<'a, T, I: CurrentThread> Inside<'a, T, I> {
    /// For the thread `tid`, whose id the word has.
    fn of(lock: &'a PiMutex<T, I>, tid: u32) -> Self {
        Self { lock, tid, stays: PhantomData }
    }

    /// Whether a thread died inside before.
    pub(in crate::lock) fn owner(&self) -> Owner {
        if self.lock.died.load(Ordering::Relaxed) { Owner::Died } else { Owner::Sound }
    }
}

impl<T, I: CurrentThread> Deref for Inside<'_, T, I> {
    type Target = T;

    fn deref(&self) -> &T {
        // SAFETY: by One Inside no other thread reaches the value, and this
        // one has a single `Inside`, borrowed here.
        unsafe { &*self.lock.value.get() }
    }
}

impl<T, I: CurrentThread> DerefMut for Inside<'_, T, I> {
    fn deref_mut(&mut self) -> &mut T {
        // SAFETY: as in `deref`, and `Inside` is borrowed mutably.
        unsafe { &mut *self.lock.value.get() }
    }
}

impl<T, I: CurrentThread> Drop for Inside<'_, T, I> {
    fn drop(&mut self) {
        // Release pairs with the Acquire in `try_enter`. Where the kernel set
        // a bit beside the id, the kernel hands over.
        let left =
            self.lock.word.compare_exchange(self.tid, FREE, Ordering::Release, Ordering::Relaxed);
        if left.is_err() {
            self.lock.hand_over();
        }
    }
}
