//! The strategy of gates whose commands are one store, with a count of how often
//! a store was called back. Beside the count it is the host's own.

use std::sync::atomic::{AtomicU32, Ordering::SeqCst};

use faregate::runtime::host::{HostStrategy, RseqArea};
use faregate::tickets::lock::{Outcome, Restartable, Rseq, Sections, Watch};

use super::device::CALLED_BACK;
use super::gates::Behind;

/// `HostRestartable`, counted.
pub(crate) type Counted = Restartable<HostStrategy, CountedSections>;

impl Behind for Counted {}

/// The host's sections.
pub(crate) struct CountedSections;

impl Sections for CountedSections {
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome {
        let outcome = Rseq::<RseqArea>::store(watch, register, word);
        if outcome == Outcome::Restarted {
            CALLED_BACK.fetch_add(1, SeqCst);
        }
        outcome
    }

    fn end_all() -> bool {
        Rseq::<RseqArea>::end_all()
    }
}
