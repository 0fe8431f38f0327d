//! A critical section where there are no interrupts to mask: one word, written
//! on the way in and on the way out. On bare metal the target's own is linked.

use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};

use critical_section::RawRestoreState;

struct OneThread;
critical_section::set_impl!(OneThread);

static MASKED: AtomicBool = AtomicBool::new(false);

// SAFETY: entries are called by one thread, so nobody is to be excluded.
unsafe impl critical_section::Impl for OneThread {
    unsafe fn acquire() -> RawRestoreState {
        let before = MASKED.load(Ordering::Relaxed);
        MASKED.store(true, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
        before
    }

    unsafe fn release(before: RawRestoreState) {
        compiler_fence(Ordering::SeqCst);
        MASKED.store(before, Ordering::Relaxed);
    }
}
