//! An allocator that counts, and passes everything on to the system's.
#![expect(unsafe_code, reason = "an allocator is unsafe; this one only counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// How often this thread has called the allocator. `const` and without
    /// `Drop`: counting allocates nothing itself.
    static CALLS: Cell<usize> = const { Cell::new(0) };
}

/// How often the calling thread has allocated or freed.
pub(crate) fn calls() -> usize {
    CALLS.get()
}

fn count() {
    CALLS.set(CALLS.get() + 1);
}

pub(crate) struct Counting;

// SAFETY: everything is passed on to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise, passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller's promise, passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}
