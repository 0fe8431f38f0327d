//! The thread that runs the entries, by a number in a static: what a flight
//! program keeps in a thread local.

use faregate_tickets::lock::CurrentThread;

use super::Register;

#[derive(Debug)]
pub(crate) enum TheThread {}

static TID: Register<u32> = Register::new(0);

/// Asks the kernel who is running.
pub(crate) fn find_out() {
    // SAFETY: asks nothing of its caller.
    let tid = unsafe { libc::gettid() };
    TID.write(tid.unsigned_abs());
}

// SAFETY: one thread runs both the set-up, which asked for its id, and the entry.
unsafe impl CurrentThread for TheThread {
    fn tid() -> u32 {
        TID.read()
    }
}
