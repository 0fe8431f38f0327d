//! A heartbeat on its way to the manager's thread.

use crate::sync::{AtomicBool, Ordering};

/// Whether a heartbeat came since it was last asked.
///
/// **No Lost Beat**: after each beat, the manager's thread takes it, or is rung
/// and will. It is rung once for all beats until it takes them.
#[derive(Debug)]
pub struct Beat(AtomicBool);

impl Default for Beat {
    fn default() -> Self {
        Self::new()
    }
}

impl Beat {
    /// None yet.
    #[must_use]
    pub fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    /// It beats: rings, unless a beat before it waits to be taken.
    pub fn beat(&self, ring: impl FnOnce()) {
        if cfg!(feature = "mutant-ring-first") {
            ring();
            self.0.store(true, Ordering::Release);
            return;
        }
        // AcqRel, with the swap in `take`: it is one order of swaps that says
        // who rings. What else the beat tells is nothing.
        if !self.0.swap(true, Ordering::AcqRel) {
            ring();
        }
    }

    /// Takes what has beaten. To be called after the ring was taken.
    pub fn take(&self) -> bool {
        // AcqRel: as in `beat`.
        self.0.swap(false, Ordering::AcqRel)
    }
}
