//! Gates behind the model checker's mutex.
#![expect(clippy::expect_used, reason = "a model that cannot go on fails")]

extern crate std;

use core::sync::atomic::AtomicU32;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use loom::sync::atomic::{AtomicUsize, Ordering};
use loom::sync::{Mutex, MutexGuard};
use loom::thread::{self, ThreadId};

use super::{Exclusion, Outcome, Owner, Sections, Shut, Strategy, Wait, Watch};
use crate::clock::Duration;
use crate::ticket::Seat;

/// Loom's mutex, for models. Time does not pass in a model:
/// [`with_until`](Exclusion::with_until) waits as long as it takes.
#[derive(Debug)]
pub struct LoomLocked;

impl Strategy for LoomLocked {
    type Lock<T: Send> = LoomMutex<T>;
}

/// A mutex whose loom can be seen to be busy.
#[derive(Debug)]
pub struct LoomMutex<T> {
    value: Mutex<T>,
    /// Whether somebody is inside, told once more. To loom the end of a
    /// critical section is no operation, so it would never let anybody try in
    /// the middle of one; the stores to this word are operations. Relaxed: it
    /// must not order what the mutex does not.
    shadow: AtomicUsize,
    /// The thread inside. Not loom's: it adds no behaviour to the model, since
    /// a thread asks only for itself.
    owner: std::sync::Mutex<Option<ThreadId>>,
}

impl<T> LoomMutex<T> {
    fn caller(&self) -> Result<ThreadId, Shut> {
        let caller = thread::current().id();
        if self.inside() == Some(caller) { Err(Shut::Reentered) } else { Ok(caller) }
    }

    fn inside(&self) -> Option<ThreadId> {
        *self.owner.lock().expect("nothing panics while it names the owner")
    }

    fn note(&self, inside: Option<ThreadId>) {
        *self.owner.lock().expect("nothing panics while it names the owner") = inside;
        self.shadow.store(usize::from(inside.is_some()), Ordering::Relaxed);
    }

    /// Runs `f` inside and leaves, also when `f` unwinds: a guard that went
    /// down with the panic would poison loom's mutex.
    fn run<R>(
        &self,
        caller: ThreadId,
        mut value: MutexGuard<'_, T>,
        f: impl FnOnce(&mut T) -> R,
    ) -> R {
        self.note(Some(caller));
        let outcome = catch_unwind(AssertUnwindSafe(|| f(&mut value)));
        self.note(None);
        drop(value);
        outcome.unwrap_or_else(|panic| resume_unwind(panic))
    }
}

impl<T: Send> Exclusion<T> for LoomMutex<T> {
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self {
            value: Mutex::new(value),
            shadow: AtomicUsize::new(0),
            owner: std::sync::Mutex::new(None),
        }
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        let caller = self.caller()?;
        let value = self.value.lock().expect("no guard goes down with a panic");
        Ok(self.run(caller, value, f))
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        let caller = self.caller()?;
        self.shadow.fetch_add(0, Ordering::Relaxed);
        let value = self.value.try_lock().map_err(|_| Shut::Busy)?;
        Ok(self.run(caller, value, f))
    }

    fn with_until<R>(&self, _: Duration, f: impl FnOnce(&mut T, Owner) -> R) -> Result<R, Shut> {
        self.with(|value| f(value, Owner::Sound))
    }
}

/// Waits as a model does: by letting the others go on.
#[derive(Debug)]
pub enum LoomWait {}

impl Wait for LoomWait {
    fn until(timeout: Duration, mut over: impl FnMut() -> bool) -> bool {
        while !over() {
            if timeout.is_zero() {
                return false;
            }
            thread::yield_now();
        }
        true
    }
}

loom::lazy_static! {
    static ref SECTION: Mutex<()> = Mutex::new(());
}

/// What the kernel promises of sections, as a model: each is done at once, and
/// [`end_all`](Sections::end_all) is a fence on both sides, of its caller and of
/// every section before and after it. What loom cannot see is the kernel's part: that
/// a section which is disturbed starts again. The soak is there for that.
#[derive(Debug)]
pub enum LoomSections {}

impl Sections for LoomSections {
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome {
        let _alone = SECTION.lock().expect("no guard goes down with a panic");
        if !watch.is_as_expected() {
            return Outcome::Refused;
        }
        register.store(word, core::sync::atomic::Ordering::Relaxed);
        Outcome::Stored
    }

    fn end_all() -> bool {
        drop(SECTION.lock().expect("no guard goes down with a panic"));
        true
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    use super::*;

    fn lock() -> loom::sync::Arc<LoomMutex<u32>> {
        loom::sync::Arc::new(LoomMutex::new(0))
    }

    /// How many executions a model had, and in how many `happens` said yes.
    fn model(happens: impl Fn() -> bool + Send + Sync + 'static) -> (usize, usize) {
        let counts = Arc::new((AtomicUsize::new(0), AtomicUsize::new(0)));
        let counted = Arc::clone(&counts);
        loom::model(move || {
            counted.0.fetch_add(1, Relaxed);
            counted.1.fetch_add(usize::from(happens()), Relaxed);
        });
        (counts.0.load(Relaxed), counts.1.load(Relaxed))
    }

    #[test]
    fn loom_sees_a_lock_both_busy_and_free() {
        let (executions, busy) = model(|| {
            let lock = lock();
            let other = lock.clone();
            let inside = thread::spawn(move || other.with(|value| *value += 1));
            let tried = lock.try_with(|value| *value += 1);
            assert_eq!(inside.join().unwrap(), Ok(()));
            assert_eq!(lock.with(|value| *value), Ok(if tried.is_ok() { 2 } else { 1 }));
            tried == Err(Shut::Busy)
        });
        assert!(busy > 0, "in none of {executions} executions was the lock busy");
        assert!(busy < executions, "in all {executions} executions the lock was busy");
    }

    #[test]
    fn what_one_did_inside_the_next_one_sees() {
        let (executions, _) = model(|| {
            let lock = lock();
            let threads = [(); 2].map(|()| {
                let lock = lock.clone();
                thread::spawn(move || lock.with_until(Duration::ZERO, |value, _| *value += 1))
            });
            for thread in threads {
                assert_eq!(thread.join().unwrap(), Ok(()));
            }
            assert_eq!(lock.with(|value| *value), Ok(2));
            true
        });
        assert!(executions > 1, "the threads were never reordered");
    }

    #[test]
    fn a_lock_entered_again_by_its_thread_refuses() {
        model(|| {
            let lock = lock();
            let again = lock.with(|_| {
                [
                    lock.with(|_| ()),
                    lock.try_with(|_| ()),
                    lock.with_until(Duration::MAX, |_, _| ()),
                ]
            });
            assert_eq!(again, Ok([Err(Shut::Reentered); 3]));
            true
        });
    }

    #[test]
    fn a_closure_that_unwinds_leaves_the_lock_usable() {
        model(|| {
            let lock = lock();
            let unwound = catch_unwind(AssertUnwindSafe(|| {
                lock.with(|_| resume_unwind(std::boxed::Box::new("gone")))
            }));
            assert!(unwound.is_err_and(|reason| reason.downcast_ref() == Some(&"gone")));
            assert_eq!(lock.try_with(|value| *value), Ok(0));
            true
        });
    }
}
