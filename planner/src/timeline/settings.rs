//! A timeline of kind state: values that are set, and hold until the next one.

use std::collections::BTreeMap;

use crate::units::Time;

use super::starts::{Bad, Within};

/// When a value is set. At one instant ends come before starts, and then the
/// plan's order decides: the last one holds.
type Key = (i64, u8, usize);

/// Who sets what: two values at most, at a start and at an end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setter {
    pub(crate) order: usize,
    pub(crate) length: i64,
    pub(crate) sets: [Option<i64>; 2],
    /// What it asks for while it runs.
    pub(crate) keep: Option<(i64, i64)>,
}

/// The values, from the present one on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    initial: i64,
    /// The first instant after all of them.
    end: i64,
    sets: BTreeMap<Key, i64>,
}

/// A range that must be kept over some instants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Range {
    pub(crate) from: i64,
    pub(crate) to: i64,
    pub(crate) min: i64,
    pub(crate) max: i64,
}

/// What is wrong: since when, and how far the value is off.
pub(crate) type Off = (i64, i128);

impl Settings {
    pub(crate) const fn new(initial: i64, end: i64) -> Self {
        Self { initial, end, sets: BTreeMap::new() }
    }

    pub(crate) fn insert(&mut self, setter: Setter, start: i64) {
        self.sets.extend(keys(setter, start));
    }

    pub(crate) fn remove(&mut self, setter: Setter, start: i64) {
        for (key, _) in keys(setter, start) {
            self.sets.remove(&key);
        }
    }

    /// The values and since when, beginning with the present one; of several at
    /// one instant the one that holds.
    pub(crate) fn points(&self, now: i64) -> Vec<(Time, i64)> {
        let mut points = vec![(Time::new(now), self.initial)];
        for (key, &value) in &self.sets {
            let at = Time::new(key.0.max(now));
            if points.last().is_some_and(|(known, _)| *known == at) {
                points.pop();
            }
            points.push((at, value));
        }
        points
    }

    /// Adds the starts to `bad` that break one of the ranges, or the setter's
    /// own one.
    ///
    /// Between two instants at which something begins or ends, seen from its
    /// start and from its end, one start is as good as the other.
    pub(crate) fn bad(&self, setter: Setter, ranges: &[Range], within: Within, bad: &mut Bad) {
        let mut cells = vec![within.0];
        let last = within.1.saturating_add(setter.length).saturating_add(1);
        let until = self.sets.range((last, 0, 0)..).next().map_or(self.end, |(key, _)| key.0);
        let seen = |range: &&Range| range.from <= until && within.0 <= range.to;
        let ranges: &[Range] = &ranges.iter().filter(seen).copied().collect::<Vec<_>>();
        let ends = ranges.iter().flat_map(|range| [range.from, range.to]).chain([self.end]);
        let near = self.sets.range((within.0.saturating_sub(1), 0, 0)..(last, 0, 0));
        for at in near.map(|(key, _)| key.0).chain(ends) {
            let seen = [at, at.saturating_add(1), at.saturating_sub(setter.length)];
            cells.extend(seen);
            cells.push(seen[2].saturating_add(1));
        }
        cells.retain(|&at| within.0 <= at && at <= within.1);
        cells.sort_unstable();
        cells.dedup();
        let nexts = cells.iter().skip(1).copied().chain([within.1.saturating_add(1)]);
        for (&first, next) in cells.iter().zip(nexts) {
            if self.off(setter, first, ranges).next().is_some() {
                bad.push((first, next - 1));
            }
        }
    }

    /// Everything that is wrong with a start, in no order.
    pub(crate) fn off<'s>(
        &'s self,
        setter: Setter,
        start: i64,
        ranges: &'s [Range],
    ) -> impl Iterator<Item = Off> + 's {
        let theirs = keys(setter, start).flat_map(move |(key, value)| {
            let until = self.next(key, setter, start);
            let before = self.before(key);
            let seen = ranges.iter();
            let seen = seen.filter(move |range| range.from < until && key.0 < range.to);
            let off = seen.filter_map(move |range| {
                let past = worse(value, before, range)?;
                Some((key.0.max(range.from), past.abs()))
            });
            off.filter(move |_| key.0 < until)
        });
        theirs.chain(self.own(setter, start))
    }

    /// The values that the setter itself cannot have while it runs.
    fn own(&self, setter: Setter, start: i64) -> Vec<Off> {
        let Some((min, max)) = setter.keep else { return Vec::new() };
        let end = start.saturating_add(setter.length);
        if start >= end {
            return Vec::new();
        }
        let mine = keys(setter, start).find(|(key, _)| key.1 == START);
        let known = self.sets.range(..=(start, u8::MAX, usize::MAX)).next_back();
        let known = known.map(|(key, value)| (*key, *value));
        let first = known.max(mine).map_or(self.initial, |(_, value)| value);
        let later = self.sets.range((start + 1, 0, 0)..(end, 0, 0));
        let mut seen: Vec<(i64, i64)> = vec![(start, first)];
        for (key, value) in later {
            // Of two at one instant the later one holds.
            seen.retain(|(at, _)| *at != key.0);
            seen.push((key.0, *value));
        }
        let off = |(at, value)| past(value, min, max).map(|past| (at, past.abs()));
        seen.into_iter().filter_map(off).collect()
    }

    /// Whether the setter, which began then and is inserted with another length,
    /// can end later: no value is further off a range than it is now, and while
    /// it runs none is off its own.
    pub(crate) fn can_end_later(
        &self,
        setter: Setter,
        (start, length): (i64, i64),
        ranges: &[Range],
    ) -> bool {
        let Some(value) = setter.sets[1] else { return true };
        let now = (start.saturating_add(length), END, setter.order);
        let later = (start.saturating_add(setter.length), END, setter.order);
        let after = (core::ops::Bound::Excluded(later), core::ops::Bound::Unbounded);
        let until = self.sets.range(after).next().map_or(self.end, |(key, _)| key.0);
        let between = self.sets.range(now..=later).map(|(key, _)| key.0);
        let mut instants: Vec<i64> = between.chain([now.0, later.0, until]).collect();
        instants.sort_unstable();
        instants.dedup();
        instants.windows(2).all(|pair| {
            let (from, to) = (pair[0], pair[1]);
            let (old, new) = (self.at(from, now, (now, value)), self.at(from, now, (later, value)));
            let mut seen = ranges.iter().filter(|range| range.from < to && from < range.to);
            let own = setter.keep.filter(|_| from < later.0);
            own.is_none_or(|(min, max)| past(new, min, max).is_none())
                && seen.all(|range| worse(new, old, range).is_none())
        })
    }

    /// The value at an instant, without what is set at `key` and with another
    /// one.
    fn at(&self, at: i64, key: Key, other: (Key, i64)) -> i64 {
        let mut known = self.sets.range(..=(at, u8::MAX, usize::MAX)).rev();
        let last = known.find(|(known, _)| **known != key).map(|(key, value)| (*key, *value));
        let other = Some(other).filter(|(key, _)| key.0 <= at);
        last.max(other).map_or(self.initial, |(_, value)| value)
    }

    /// When the value that is set at `key` is set again.
    fn next(&self, key: Key, setter: Setter, start: i64) -> i64 {
        let (after, last) = (core::ops::Bound::Excluded(key), core::ops::Bound::Unbounded);
        let theirs = self.sets.range((after, last)).next().map(|(key, _)| key.0);
        let mine = keys(setter, start).map(|(key, _)| key).filter(|&other| other > key).min();
        let mine = mine.map(|key| key.0);
        theirs.into_iter().chain(mine).fold(self.end, i64::min)
    }

    /// The value that would hold without what is set at `key`.
    fn before(&self, key: Key) -> i64 {
        self.sets.range(..key).next_back().map_or(self.initial, |(_, value)| *value)
    }
}

const END: u8 = 0;
const START: u8 = 1;

fn keys(setter: Setter, start: i64) -> impl Iterator<Item = (Key, i64)> {
    let Setter { order, length, sets, .. } = setter;
    let keys = [(start, START, order), (start.saturating_add(length), END, order)];
    keys.into_iter().zip(sets).filter_map(|(key, value)| Some((key, value?)))
}

/// How far a value is off a range, if it is further off than the one before.
fn worse(value: i64, before: i64, range: &Range) -> Option<i128> {
    let new = past(value, range.min, range.max)?;
    let old = past(before, range.min, range.max).unwrap_or(0);
    (new.abs() > old.abs() || new.signum() != old.signum()).then_some(new)
}

/// How far a value is off a range: negative below it.
pub(crate) fn past(value: i64, min: i64, max: i64) -> Option<i128> {
    let (value, min, max) = (i128::from(value), i128::from(min), i128::from(max));
    match () {
        () if value < min => Some(value - min),
        () if value > max => Some(value - max),
        () => None,
    }
}

#[cfg(test)]
mod tests;
