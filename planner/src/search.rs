//! The earliest start of a candidate that keeps every limit.
//!
//! Exact: the millisecond before it breaks one. Starts between two that are
//! tried are known to break what the first of the two breaks.
//!
//! With one exception, so that a plan is made in bounded time: where so many
//! starts have been tried for one candidate that nothing is learned from one
//! about the next, the search goes on in steps of a thousandth of what there is
//! to search, and then looks once more at the step before what it finds. That
//! keeps every limit as ever, and may not be the earliest.

use crate::derive::Candidate;
use crate::derive::var::Var;
use crate::judge::{Rest, Verdict};
use crate::timeline::Intervals;
use crate::units::Time;

/// How much work it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Candidates that were tried.
    pub candidates: u64,
    /// Starts that were tried, each a derived world.
    pub starts: u64,
}

/// So many starts are tried for a candidate before steps are long, and then as
/// many again: most candidates need a few dozen.
const PATIENCE: u64 = 1_000;

/// What is searched, and with how much patience.
#[derive(Clone, Copy)]
struct Stretch<'s> {
    item: usize,
    starts: &'s Intervals,
    optional: bool,
    patience: u64,
}

/// Where a search came to.
enum Found {
    At(i64),
    /// There, and what lies from the other one up to it was passed over.
    After(i64, i64),
    Nowhere,
}

impl Rest<'_> {
    /// The earliest of these starts that keeps the limits that depend on what
    /// is derived; the others are kept at all of them.
    pub(crate) fn earliest(
        &self,
        item: usize,
        starts: &Intervals,
        optional: bool,
        effort: &mut Effort,
    ) -> Option<i64> {
        let stretch = Stretch { item, starts, optional, patience: PATIENCE };
        self.earliest_of(stretch, effort)
    }

    fn earliest_of(&self, stretch: Stretch<'_>, effort: &mut Effort) -> Option<i64> {
        match self.search(stretch, effort) {
            Found::At(start) => Some(start),
            Found::Nowhere => None,
            Found::After(passed, start) => {
                let gap = Intervals::between(Time::new(passed), Time::new(start - 1));
                let starts = &stretch.starts.intersection(&gap);
                // What is passed over once more has shorter steps.
                match self.search(Stretch { starts, ..stretch }, effort) {
                    Found::At(earlier) | Found::After(_, earlier) => Some(earlier),
                    Found::Nowhere => Some(start),
                }
            }
        }
    }

    fn search(&self, stretch: Stretch<'_>, effort: &mut Effort) -> Found {
        let Stretch { item, starts, optional, patience } = stretch;
        let length = self.problem.items[item].shortest;
        let long = long_step(starts, patience);
        let (mut tried, mut passed) = (0, None);
        for (first, last) in starts.iter() {
            let mut start = first.get();
            while start <= last.get() {
                if let Some(drained) = self.drained_until(item, start, optional) {
                    (start, passed) = (drained + 1, None);
                    continue;
                }
                let end = Var::shifting(start + length);
                let candidate = Candidate { item, start: Var::shifting(start), end };
                effort.starts += 1;
                tried += 1;
                let shift = match self.judge(candidate, optional, false) {
                    Verdict::Fits(_) => {
                        return passed.map_or(Found::At(start), |from| Found::After(from, start));
                    }
                    Verdict::Breaks(shift) => shift.saturating_add(1),
                };
                let step = if tried > patience { shift.max(long) } else { shift };
                passed = (step > shift).then_some(start.saturating_add(shift));
                start = start.saturating_add(step);
            }
        }
        Found::Nowhere
    }

    /// The latest end of something that begins then, up to which it can be
    /// made longer millisecond by millisecond with every limit kept; or where
    /// patience ends on the way there.
    pub(crate) fn latest_end(
        &self,
        item: usize,
        start: i64,
        (end, last): (i64, i64),
        effort: &mut Effort,
    ) -> i64 {
        let (mut good, mut next) = (end, end);
        for _ in 0..PATIENCE {
            if next > last {
                break;
            }
            let (start, end) = (Var::fixed(start), Var::shifting(next));
            effort.starts += 1;
            match self.judge(Candidate { item, start, end }, true, true) {
                Verdict::Breaks(_) => break,
                Verdict::Fits(shift) => good = next.saturating_add(shift).min(last),
            }
            next = good + 1;
        }
        good
    }
}

/// So long that all of it is gone through in about as many steps as there is
/// patience for.
fn long_step(starts: &Intervals, patience: u64) -> i64 {
    let ends = || starts.iter().map(|(_, last)| last.get());
    let span = starts.first().zip(ends().max()).map_or(0, |(first, last)| last - first.get());
    (span / i64::try_from(patience.max(1)).unwrap_or(i64::MAX)).max(1)
}

#[cfg(test)]
mod small;
#[cfg(test)]
mod tests;
