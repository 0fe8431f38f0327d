//! A start range that opens earlier or closes later, or a later cutoff.

use crate::timeline::Intervals;
use crate::units::Time;

use super::super::{Change, Number};
use super::{Turn, change, least};

/// A start range, and what is left of it.
struct Range {
    at: usize,
    /// As the ground wrote it.
    opens: i64,
    closes: i64,
    /// The last start that its cutoff leaves.
    ends: i64,
}

impl Turn<'_, '_> {
    /// The smallest change of when one of its ranges is, and of one's cutoff.
    pub(super) fn ranges(&self) -> impl Iterator<Item = Change> {
        let problem = self.pass.problem;
        let it = &problem.items[self.item];
        let from = if it.cleanup { problem.now } else { self.pass.from };
        let first = self.pass.after(self.item).ok().map(|after| after.max(from));
        let ranges = problem.plan.activities[self.item].starts.iter().enumerate();
        let ranges = ranges.map(|(at, range)| Range {
            at,
            opens: range.from.get(),
            closes: range.to.get(),
            ends: range.cutoff.get().saturating_sub(it.shortest),
        });
        let (mut moved, mut longer) = (Vec::new(), Vec::new());
        for range in ranges {
            let Some(first) = first else { continue };
            moved.extend(self.earlier(&range, first));
            moved.extend(self.later(&range, first));
            longer.extend(self.longer(&range, first));
        }
        let smallest = |all: Vec<Change>| all.into_iter().min_by_key(|it| (it.by, it.start));
        [smallest(moved), smallest(longer)].into_iter().flatten()
    }

    /// Nothing is over after the plan's end.
    fn last(&self) -> i64 {
        self.pass.problem.end - self.pass.problem.items[self.item].shortest
    }

    fn first_within(&self, from: i64, to: i64) -> Option<i64> {
        let starts = Intervals::between(Time::new(from), Time::new(to));
        self.fits(&self.pass.trial(self.item), &starts)
    }

    fn earlier(&self, range: &Range, first: i64) -> Option<Change> {
        let to = range.closes.min(range.ends).min(self.last());
        let found = |by: i64| self.first_within((range.opens - by).max(first), to);
        let most = range.opens.saturating_sub(first);
        let found = if most > 0 { least(most, found) } else { None };
        found.map(|found| change(Number::From(range.at), found))
    }

    /// None of the starts before is valid, so the first one is as near as can
    /// be.
    fn later(&self, range: &Range, first: i64) -> Option<Change> {
        let from = range.closes.saturating_add(1).max(range.opens).max(first);
        let start = self.first_within(from, range.ends.min(self.last()))?;
        Some(change(Number::To(range.at), (start - range.closes, start)))
    }

    fn longer(&self, range: &Range, first: i64) -> Option<Change> {
        let from = range.ends.saturating_add(1).max(range.opens).max(first);
        let start = self.first_within(from, range.closes.min(self.last()))?;
        Some(change(Number::Cutoff(range.at), (start - range.ends, start)))
    }
}
