//! Sets of instants: sorted, apart from each other, both ends inclusive.

use core::iter::Peekable;

use crate::units::Time;

/// A set of instants, as intervals. No two of them touch, so equal sets are
/// equal values.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Intervals(Vec<(i64, i64)>);

impl Intervals {
    /// No instant.
    #[must_use]
    pub const fn none() -> Self {
        Self(Vec::new())
    }

    /// From one instant to another, both inclusive; none where the first is the
    /// later one.
    #[must_use]
    pub fn between(first: Time, last: Time) -> Self {
        if first <= last { Self(vec![(first.get(), last.get())]) } else { Self::none() }
    }

    /// The union of any intervals, in any order; those that end before they
    /// begin count nothing.
    #[must_use]
    pub fn of(any: impl IntoIterator<Item = (Time, Time)>) -> Self {
        let mut raw: Vec<_> = any.into_iter().map(|(a, b)| (a.get(), b.get())).collect();
        Self::united(&mut raw)
    }

    pub(crate) fn united(raw: &mut Vec<(i64, i64)>) -> Self {
        raw.retain(|(first, last)| first <= last);
        raw.sort_unstable();
        let mut all: Vec<(i64, i64)> = Vec::with_capacity(raw.len());
        for &(first, last) in raw.iter() {
            match all.last_mut() {
                Some(before) if first <= before.1.saturating_add(1) => {
                    before.1 = before.1.max(last);
                }
                _ => all.push((first, last)),
            }
        }
        Self(all)
    }

    /// Whether there is no instant in it.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many intervals there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// The first instant, if there is one.
    #[must_use]
    pub fn first(&self) -> Option<Time> {
        self.0.first().map(|&(first, _)| Time::new(first))
    }

    /// The first instant that is not before `at`.
    #[must_use]
    pub fn first_from(&self, at: Time) -> Option<Time> {
        let next = self.0.partition_point(|&(_, last)| last < at.get());
        self.0.get(next).map(|&(first, _)| Time::new(first.max(at.get())))
    }

    /// Whether an instant is in it.
    #[must_use]
    pub fn contains(&self, at: Time) -> bool {
        self.first_from(at) == Some(at)
    }

    /// The intervals, in order, both ends inclusive.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (Time, Time)> + '_ {
        self.0.iter().map(|&(first, last)| (Time::new(first), Time::new(last)))
    }

    /// The instants of either.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let mut raw = [self.0.as_slice(), other.0.as_slice()].concat();
        Self::united(&mut raw)
    }

    /// The instants of both.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let (mut ours, mut theirs) = (self.0.iter().peekable(), other.0.iter().peekable());
        let mut both = Vec::new();
        while let (Some(&&a), Some(&&b)) = (ours.peek(), theirs.peek()) {
            let (first, last) = (a.0.max(b.0), a.1.min(b.1));
            if first <= last {
                both.push((first, last));
            }
            pass(&mut ours, &mut theirs, a.1 < b.1);
        }
        Self(both)
    }

    /// The instants of this one that are not in the other.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        let mut left = Vec::with_capacity(self.0.len());
        let mut taken = other.0.iter().peekable();
        for &(mut first, last) in &self.0 {
            while taken.next_if(|&&(_, end)| end < first).is_some() {}
            while let Some(&&(from, to)) = taken.peek()
                && from <= last
            {
                if first < from {
                    left.push((first, from - 1));
                }
                first = to.saturating_add(1);
                if to > last {
                    break;
                }
                taken.next();
            }
            if first <= last {
                left.push((first, last));
            }
        }
        Self(left)
    }
}

/// Leaves the interval behind that ends first.
fn pass<I: Iterator>(ours: &mut Peekable<I>, theirs: &mut Peekable<I>, ours_ends_first: bool) {
    if ours_ends_first {
        ours.next();
    } else {
        theirs.next();
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn some() -> impl Strategy<Value = Vec<(Time, Time)>> {
        let one = (0i64..40, -2i64..9).prop_map(|(a, n)| (Time::new(a), Time::new(a + n)));
        proptest::collection::vec(one, 0..8)
    }

    fn instants(all: &[(Time, Time)]) -> BTreeSet<i64> {
        all.iter().flat_map(|&(a, b)| a.get()..=b.get()).collect()
    }

    fn of(set: &Intervals) -> BTreeSet<i64> {
        instants(&set.iter().collect::<Vec<_>>())
    }

    fn apart(set: &Intervals) -> bool {
        let all: Vec<_> = set.iter().collect();
        all.iter().all(|(a, b)| a <= b) && all.windows(2).all(|w| w[0].1.get() + 1 < w[1].0.get())
    }

    proptest! {
        #[test]
        fn they_are_sets(a in some(), b in some(), at in -2i64..50) {
            let (x, y) = (instants(&a), instants(&b));
            let (p, q) = (Intervals::of(a), Intervals::of(b));
            let results = [p.clone(), p.union(&q), p.intersection(&q), p.without(&q)];
            prop_assert!(results.iter().all(apart), "{results:?}");
            prop_assert_eq!(of(&results[0]), x.clone());
            prop_assert_eq!(of(&results[1]), &x | &y);
            prop_assert_eq!(of(&results[2]), &x & &y);
            prop_assert_eq!(of(&results[3]), &x - &y);
            prop_assert_eq!(p.contains(Time::new(at)), x.contains(&at));
            prop_assert_eq!(p.first_from(Time::new(at)).map(Time::get), x.range(at..).next().copied());
            prop_assert_eq!(p.first().map(Time::get), x.first().copied());
        }
    }
}
