//! Dice, and what is read from them.

use faregate_devices_sim::Dice;
use faregate_planner::units::{Span, Time};

/// Dice for one execution.
pub(crate) struct Throws(Dice);

impl Throws {
    pub(crate) fn new(seed: u64, purpose: u64) -> Self {
        Self(Dice::new(seed, purpose))
    }

    /// Both ends are possible.
    pub(crate) fn number(&mut self, low: u64, high: u64) -> u64 {
        low + self.0.below(high.saturating_sub(low) + 1)
    }

    pub(crate) fn index(&mut self, low: usize, high: usize) -> usize {
        low + self.0.index(high.saturating_sub(low) + 1)
    }

    /// So often in a hundred.
    pub(crate) fn chance(&mut self, percent: u64) -> bool {
        self.0.below(100) < percent
    }

    pub(crate) fn one_of<T: Copy + Default>(&mut self, all: &[T]) -> T {
        all.get(self.0.index(all.len())).copied().unwrap_or_default()
    }

    pub(crate) fn seconds(&mut self, low: u64, high: u64) -> Span {
        Span::from_secs(i64::try_from(self.number(low, high)).unwrap_or(0))
    }

    pub(crate) fn minutes(&mut self, low: u64, high: u64) -> Span {
        self.seconds(low * 60, high * 60)
    }

    /// To the millisecond.
    pub(crate) fn within(&mut self, from: Time, to: Time) -> Time {
        let length = u64::try_from(to.since(from).get()).unwrap_or(0);
        from.after(Span::new(i64::try_from(self.number(0, length)).unwrap_or(0)))
    }
}
