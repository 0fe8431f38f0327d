//! The strategy of gates whose commands are one store, with a count of how often
//! a store was called back. Beside the count it is the host's own.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use faregate::runtime::host::{HostStrategy, RseqArea};
use faregate::tickets::lock::{Outcome as Ended, Restartable, Rseq, Sections, Watch};

use super::Outcome;
use super::gates::{self, Behind};
use super::measured::Measured;
use super::stage::{Limits, Stage};

/// `HostRestartable`, counted.
pub(crate) type Counted = Restartable<HostStrategy, CountedSections>;

impl Behind for Counted {}

/// The host's sections.
pub(crate) struct CountedSections;

static RESTARTS: AtomicU64 = AtomicU64::new(0);

/// [`gates::any_instant`], with the count.
pub(crate) fn any_instant(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    // Relaxed: the thread that counts has not begun, or has been joined.
    RESTARTS.store(0, Relaxed);
    let mut measured = gates::any_instant::<Counted>(stage, limits)?;
    measured.restarts = Some(RESTARTS.load(Relaxed));
    Ok(measured)
}

impl Sections for CountedSections {
    fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Ended {
        let ended = Rseq::<RseqArea>::store(watch, register, word);
        if ended == Ended::Restarted {
            RESTARTS.fetch_add(1, Relaxed);
        }
        ended
    }

    fn end_all() -> bool {
        Rseq::<RseqArea>::end_all()
    }
}
