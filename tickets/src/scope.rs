//! Scopes: what one increment revokes all of, an agent's tickets or a broker's.

use crate::id::Priority;
use crate::sync::{AtomicUsize, Ordering};

/// The epoch and the priority floor of an agent, or of a whole broker.
///
/// **Late Epoch Invariant.** Whoever makes tickets valid reads the epoch first
/// and the floor second, and stamps the epoch it read. Whoever enters safe mode
/// sets the floor first and increments the epoch second. So a ticket below the
/// floor either carries a stamp from before the increment, and is not valid, or
/// was decided on by somebody who had to see the floor.
#[derive(Debug)]
pub struct Scope {
    epoch: AtomicUsize,
    /// The least level that may become valid; 0 outside safe mode.
    floor: AtomicUsize,
    /// How many bars there have been, so that the agent knows when to look for
    /// them.
    bars: AtomicUsize,
}

/// What somebody read of a scope before deciding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Seen {
    /// The epoch, read first.
    pub epoch: usize,
    /// The priority floor, read second.
    pub floor: usize,
}

impl Seen {
    /// Whether a ticket of this priority may become valid.
    #[must_use]
    pub fn admits(self, priority: Priority) -> bool {
        usize::from(priority.level()) >= self.floor
    }
}

impl Scope {
    /// A scope in which nothing is revoked.
    #[must_use]
    pub fn new() -> Self {
        Self { epoch: AtomicUsize::new(1), floor: AtomicUsize::new(0), bars: AtomicUsize::new(0) }
    }

    /// Revokes every ticket of the scope.
    ///
    /// # Timing
    /// Constant: one atomic increment.
    pub fn revoke_all(&self) {
        // Release: pairs with the Acquire in `read`, so that who sees this
        // increment sees the floor stored before it.
        self.epoch.fetch_add(1, Ordering::Release);
    }

    /// Says that a standing was barred.
    ///
    /// # Timing
    /// Constant: one atomic increment.
    pub fn note_bar(&self) {
        // Release: pairs with the Acquire in `bars`, so that who counts this
        // one finds the bar.
        self.bars.fetch_add(1, Ordering::Release);
    }

    /// How many bars there have been.
    #[must_use]
    pub fn bars(&self) -> usize {
        self.bars.load(Ordering::Acquire)
    }

    /// Like [`Scope::revoke_all`]; answers the epoch that it ended.
    pub(crate) fn revoke_all_after(&self) -> usize {
        // As in `revoke_all`. The old value costs nothing here: fetch_add has
        // an instruction that answers it.
        self.epoch.fetch_add(1, Ordering::Release)
    }

    /// Sets the floor and revokes every ticket of the scope.
    ///
    /// # Timing
    /// Constant: one atomic store, one atomic increment.
    pub fn enter_safe_mode(&self, floor: Priority) {
        self.set_floor(floor);
        self.revoke_all();
    }

    pub(crate) fn set_floor(&self, floor: Priority) {
        // Release: who acquires this floor sees the exemption announced before
        // it. The increment comes after it by its own Release.
        #[cfg(not(feature = "mutant-relaxed-floor"))]
        self.floor.store(usize::from(floor.level()), Ordering::Release);
        #[cfg(feature = "mutant-relaxed-floor")]
        self.floor.store(usize::from(floor.level()), Ordering::Relaxed);
    }

    /// Lifts the floor. Tickets come back as their agents get to them.
    ///
    /// # Timing
    /// Constant: one atomic store.
    pub fn leave_safe_mode(&self) {
        // Relaxed: a reader that still sees the floor only waits for the next
        // service, which the caller asks for after this.
        self.floor.store(0, Ordering::Relaxed);
    }

    /// The epoch, then the floor.
    #[must_use]
    pub fn read(&self) -> Seen {
        #[cfg(feature = "mutant-late-epoch")]
        {
            let floor = self.floor.load(Ordering::Relaxed);
            return Seen { epoch: self.epoch.load(Ordering::Acquire), floor };
        }
        #[cfg(not(feature = "mutant-late-epoch"))]
        {
            // Acquire: pairs with the Release increment; the floor read after
            // it is at least as new. Acquire again: pairs with `set_floor`, which
            // can be seen before the increment.
            let epoch = self.epoch.load(Ordering::Acquire);
            Seen { epoch, floor: self.floor.load(Ordering::Acquire) }
        }
    }

    /// The floor in force, where safe mode is.
    #[must_use]
    pub fn floor(&self) -> Option<Priority> {
        // Relaxed: a report, nothing is decided on it.
        let level = self.floor.load(Ordering::Relaxed);
        u8::try_from(level).ok().filter(|level| *level > 0).map(Priority::new)
    }

    /// The word that a revocation changes.
    pub(crate) fn word(&self) -> &AtomicUsize {
        &self.epoch
    }

    pub(crate) fn epoch(&self) -> usize {
        // Relaxed: Closed Door asks that an invocation that happens after a
        // revocation sees it, which coherence alone gives; one that does not
        // happen after it may see either. What is visible at quiescence is
        // ordered by the gate's lock.
        self.epoch.load(Ordering::Relaxed)
    }
}

impl Default for Scope {
    fn default() -> Self {
        Self::new()
    }
}
