//! Expanding activities are made longer, each as far as everything stays valid.

use crate::derive::Placement;
use crate::timed::Slot;
use crate::timeline::Claim;
use crate::units::{Span, Time};

use super::Pass;
use super::begin::claim;

impl Pass<'_> {
    /// In order; nothing else is moved or removed.
    pub(super) fn expand(&mut self, order: &[usize]) {
        for &item in order {
            if self.problem.items[item].expanding
                && !self.committed[item]
                && let Some(slot) = self.slots[item]
            {
                self.lengthen(item, slot, Time::new(i64::MAX));
            }
        }
    }

    /// Up to `until` at most.
    pub(super) fn lengthen(&mut self, item: usize, slot: Slot, until: Time) {
        let (start, end) = (slot.start.get(), slot.end.get());
        let last = self.last(item, slot).min(until.get());
        if last <= end {
            return;
        }
        // Timelines and the world are still those in which it has its present
        // length: what is compared with.
        let last = self.last_on_timelines(item, slot, last);
        self.placed.remove(self.problem, Placement { item, start, end });
        self.timelines.remove(&self.claims[item], slot.start);
        let mut effort = self.effort;
        let last = self.rest().latest_end(item, start, (end, last), &mut effort);
        self.effort = effort;
        self.claims[item] = claim(self.problem, item, Span::new(last - start));
        let version = self.version;
        self.put(item, Slot { end: Time::new(last), ..slot });
        if last == end {
            self.version = version;
        }
    }

    /// What its own limits leave: its longest duration, its cutoff, and what
    /// waits for its end.
    fn last(&self, item: usize, slot: Slot) -> i64 {
        let it = &self.problem.items[item];
        let longest = slot.start.get() + it.longest;
        let cutoff = it.ranges.get(slot.range).map_or(longest, |range| range.last);
        let waits = |other: usize| self.problem.items[other].after.iter().any(|on| on.0 == item);
        let starts = (0..self.slots.len()).filter(|&other| waits(other));
        let starts = starts.filter_map(|other| self.slots[other].map(|slot| slot.start.get()));
        starts.chain([longest, cutoff]).min().unwrap_or(longest)
    }

    /// What bits, engines, data and named timelines leave, up to the first end
    /// that they refuse: what happens at its end can be in the way of others at
    /// some ends and not at later ones.
    fn last_on_timelines(&self, item: usize, slot: Slot, last: i64) -> i64 {
        let now = &self.claims[item];
        let fits = |end: i64| {
            let longer = claim(self.problem, item, Span::new(end - slot.start.get()));
            self.timelines.lengthens(now, &longer, slot.start)
        };
        let mut good = slot.end.get();
        let last = self.downlink(now, good, last);
        for next in self.timelines.ends(now, (good, last)) {
            if !fits(next) {
                return last_good(good, next, fits);
            }
            good = next;
        }
        good
    }

    /// Its end frees data: not so late that there would be too much.
    fn downlink(&self, claim: &Claim, end: i64, last: i64) -> i64 {
        if claim.data >= 0 {
            return last;
        }
        let max = self.problem.plan.max_delta_data.get();
        let mut volumes = self.timelines.volumes(Time::new(end));
        // Until it ends, what it frees is still on board.
        let full = volumes.find(|(_, total)| *total - claim.data > max);
        full.map_or(last, |(at, _)| last.min(at.get().max(end)))
    }
}

/// Between an end that is good and a later one that is bad: the last that is
/// good, where there is no good one after a bad one.
fn last_good(mut good: i64, mut bad: i64, is_good: impl Fn(i64) -> bool) -> i64 {
    while bad - good > 1 {
        let middle = good + (bad - good) / 2;
        if is_good(middle) { good = middle } else { bad = middle }
    }
    good
}
