//! The thread that runs the entries, by a number in a static: what a flight
//! program keeps in a thread local.

use faregate_tickets::lock::{CurrentThread, Registered, Rseq};

use super::Register;

#[derive(Debug)]
pub(crate) enum TheThread {}

static TID: Register<u32> = Register::new(0);

/// How far the thread's `rseq` area is from its thread pointer.
static AREA: Register<isize> = Register::new(0);

unsafe extern "C" {
    /// Where the C library has registered each thread's area.
    #[link_name = "__rseq_offset"]
    static OFFSET: isize;
}

/// Asks the kernel who is running, and tells it that sections will be ended.
pub(crate) fn find_out() {
    // SAFETY: asks nothing of its caller.
    let tid = unsafe { libc::gettid() };
    TID.write(tid.unsigned_abs());
    // SAFETY: glibc writes it before the program begins.
    AREA.write(unsafe { OFFSET });
    assert!(Rseq::<TheThread>::is_supported(), "this kernel ends no sections");
}

// SAFETY: one thread runs both the set-up, which asked for its id, and the entry.
unsafe impl CurrentThread for TheThread {
    fn tid() -> u32 {
        TID.read()
    }
}

// SAFETY: the C library has registered the area of each thread at this distance,
// with the signature of the target, before any of our code runs.
unsafe impl Registered for TheThread {
    fn offset() -> isize {
        AREA.read()
    }
}
