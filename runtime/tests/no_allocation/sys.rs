//! An allocator that counts for each thread, and passes everything on to the
//! system's. Any thread's count can be read, by the kernel's number for it.
#![expect(unsafe_code, reason = "an allocator is unsafe; this one only counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering::Relaxed};

/// How many threads a test may have, all told.
const THREADS: usize = 4096;

/// What is counted of one thread.
struct Count {
    tid: AtomicU32,
    calls: AtomicUsize,
}

static COUNTS: [Count; THREADS] =
    [const { Count { tid: AtomicU32::new(0), calls: AtomicUsize::new(0) } }; THREADS];
static USED: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// This thread's place among the counts, from 1; 0 while it has none.
    /// `const` and without `Drop`: counting allocates nothing itself.
    static PLACE: Cell<usize> = const { Cell::new(0) };
}

/// How often the calling thread has allocated or freed.
pub(crate) fn calls() -> usize {
    place().calls.load(Relaxed)
}

/// How often the thread with this number has.
pub(crate) fn calls_of(tid: u32) -> usize {
    COUNTS
        .iter()
        .filter(|count| count.tid.load(Relaxed) == tid)
        .map(|count| count.calls.load(Relaxed))
        .sum()
}

fn place() -> &'static Count {
    if PLACE.get() == 0 {
        PLACE.set(USED.fetch_add(1, Relaxed) + 1);
        let tid = rustix::thread::gettid().as_raw_nonzero().get().unsigned_abs();
        COUNTS[PLACE.get() - 1].tid.store(tid, Relaxed);
    }
    &COUNTS[PLACE.get() - 1]
}

fn count() {
    place().calls.fetch_add(1, Relaxed);
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
