//! A mutex that one compare-exchange enters: the least that the adapter for
//! `lock_api` can stand on. One thread has it, so nobody ever waits.

use core::num::NonZeroUsize;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;

use lock_api::{GetThreadId, GuardNoSend, RawMutex, RawMutexTimed};

#[derive(Debug)]
pub(crate) struct OneExchange(AtomicBool);

// SAFETY: one exchange from `false` is behind every lock that is had, and
// whoever has it is the only one to store `false`.
unsafe impl RawMutex for OneExchange {
    const INIT: Self = Self(AtomicBool::new(false));
    type Guard = GuardNoSend;

    fn lock(&self) -> GuardNoSend {
        match self.try_lock() {
            Some(guard) => guard,
            None => audit_cold_wait(self),
        }
    }

    fn try_lock(&self) -> Option<GuardNoSend> {
        // Acquire pairs with the Release in `unlock`.
        let had = self.0.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed);
        had.ok().map(|_| GuardNoSend::new())
    }

    unsafe fn unlock(&self, _: GuardNoSend) {
        self.0.store(false, Ordering::Release);
    }

    fn is_locked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

// SAFETY: as `RawMutex`.
unsafe impl RawMutexTimed for OneExchange {
    type Duration = Duration;
    type Instant = ();

    fn try_lock_for(&self, _: Duration) -> Option<GuardNoSend> {
        self.try_lock()
    }

    fn try_lock_until(&self, (): ()) -> Option<GuardNoSend> {
        self.try_lock()
    }
}

/// Where the mutex of an operating system would wait.
#[cold]
#[inline(never)]
fn audit_cold_wait(mutex: &OneExchange) -> GuardNoSend {
    loop {
        if let Some(guard) = mutex.try_lock() {
            return guard;
        }
        core::hint::spin_loop();
    }
}

#[derive(Debug)]
pub(crate) struct OneThread;

// SAFETY: entries are called by one thread.
unsafe impl GetThreadId for OneThread {
    const INIT: Self = Self;

    fn nonzero_thread_id(&self) -> NonZeroUsize {
        NonZeroUsize::MIN
    }
}
