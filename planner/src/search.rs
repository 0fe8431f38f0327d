//! The earliest start of a candidate that keeps every limit.
//!
//! Exact: the millisecond before it breaks one. Starts between two that are
//! tried are known to break what the first of the two breaks.
//!
//! With one exception, so that a plan is made in bounded time: where so many
//! starts have been tried for one candidate that nothing is learned from one
//! about the next, the search goes on in steps that grow. What it finds keeps
//! every limit as ever, and may not be the earliest.

use crate::derive::Candidate;
use crate::derive::var::Var;
use crate::judge::{Rest, Verdict};
use crate::timeline::Intervals;

/// How much work it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Candidates that were tried.
    pub candidates: u64,
    /// Starts that were tried, each a derived world.
    pub starts: u64,
}

/// So many starts are tried for a candidate before steps grow: most candidates
/// need a few dozen.
const PATIENCE: u64 = 1_000;

/// At least so far goes the next step.
const fn stride(tried: u64) -> i64 {
    // Doubled with each one: a sol is gone through in thirty.
    let over = tried.saturating_sub(PATIENCE);
    1 << if over < 32 { over } else { 32 }
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
        let length = self.problem.items[item].shortest;
        let mut tried = 0;
        for (first, last) in starts.iter() {
            let mut start = first.get();
            while start <= last.get() {
                if let Some(drained) = self.drained_until(item, start, optional) {
                    start = drained + 1;
                    continue;
                }
                let end = Var::shifting(start + length);
                let candidate = Candidate { item, start: Var::shifting(start), end };
                effort.starts += 1;
                tried += 1;
                match self.judge(candidate, optional, false) {
                    Verdict::Fits(_) => return Some(start),
                    Verdict::Breaks(shift) => {
                        let step = shift.saturating_add(1).max(stride(tried));
                        start = start.saturating_add(step);
                    }
                }
            }
        }
        None
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

#[cfg(test)]
mod small;
#[cfg(test)]
mod tests;
