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
    /// Who was barred since the agent looked; see [`Bars`].
    bars: AtomicUsize,
}

/// Where to look for bars: the seats whose numbers have certain low bits. With
/// no more seats than a word has bits, these are exactly the barred ones; with
/// 60 000, one bar concerns a thousand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Bars(usize);

impl Bars {
    /// Whether there was none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The seats to look at, of so many.
    pub fn seats(self, seats: u16) -> impl Iterator<Item = u16> {
        let mut left = self.0;
        let groups = core::iter::from_fn(move || {
            let group = left.trailing_zeros();
            left &= left.wrapping_sub(1);
            (group < usize::BITS).then_some(group)
        });
        let of_group =
            |group: u32| core::iter::successors(Some(group), |seat| Some(seat + usize::BITS));
        let to_the_last = move |group| of_group(group).take_while(move |seat| *seat < seats.into());
        groups.flat_map(to_the_last).filter_map(|seat| u16::try_from(seat).ok())
    }

    fn of(seat: u16) -> usize {
        1 << (u32::from(seat) % usize::BITS)
    }
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

    /// Says that the standing in this seat was barred.
    ///
    /// # Timing
    /// Constant: one atomic operation.
    pub fn note_bar(&self, seat: u16) {
        // Release: pairs with the Acquire in `take_bars`, so that who takes
        // this one finds the bar.
        self.bars.fetch_or(Bars::of(seat), Ordering::Release);
    }

    /// Where somebody was barred since this was last asked, for the agent: it
    /// asks under its lock, and looks before it leaves.
    ///
    /// # Timing
    /// Constant: an atomic load, and if there was a bar, an atomic exchange.
    #[must_use]
    pub fn take_bars(&self) -> Bars {
        // Relaxed: that there is nothing says nothing about other memory.
        if self.bars.load(Ordering::Relaxed) == 0 {
            return Bars(0);
        }
        // A bar that comes in between is taken too, or stays for the next.
        Bars(self.bars.swap(0, Ordering::Acquire))
    }

    /// Whether there are bars that nobody has taken.
    #[must_use]
    pub fn has_bars(&self) -> bool {
        self.bars.load(Ordering::Relaxed) != 0
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

#[cfg(all(test, not(loom), target_pointer_width = "64"))]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const SEATS: u16 = u16::MAX - 1;
    const GROUPS: u16 = 64;

    fn barred(seats: &[u16]) -> Vec<u16> {
        let scope = Scope::new();
        seats.iter().for_each(|seat| scope.note_bar(*seat));
        scope.take_bars().seats(SEATS).collect()
    }

    #[test]
    fn whoever_was_barred_is_looked_at() {
        for seat in (0..SEATS).step_by(97) {
            assert!(barred(&[seat]).contains(&seat), "{seat}");
        }
        let three = barred(&[3, 3 + GROUPS, 40_000]);
        assert!([3, 3 + GROUPS, 40_000].iter().all(|seat| three.contains(seat)));
    }

    #[test]
    fn one_bar_concerns_its_group_and_nobody_else() {
        assert_eq!(barred(&[]), []);
        for seat in [0, 77, SEATS - 1] {
            let concerned = barred(&[seat]);
            assert!(concerned.len() <= usize::from(SEATS / GROUPS) + 1);
            assert!(concerned.iter().all(|other| other % GROUPS == seat % GROUPS));
        }
    }

    #[test]
    fn few_seats_are_each_a_group() {
        let scope = Scope::new();
        scope.note_bar(5);
        scope.note_bar(7);
        assert_eq!(scope.take_bars().seats(8).collect::<Vec<_>>(), [5, 7]);
    }

    #[test]
    fn a_bar_is_taken_once() {
        let scope = Scope::new();
        scope.note_bar(9);
        assert!(scope.has_bars());
        assert!(!scope.take_bars().is_empty());
        assert!(!scope.has_bars() && scope.take_bars().is_empty());
    }
}
