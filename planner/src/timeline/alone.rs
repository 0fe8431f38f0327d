//! What is broken by what is inserted, whoever is to blame.

use crate::units::Time;

use super::claim::FINE;
use super::line::{Line, Piece};
use super::named::{Named, Outcome, keep};
use super::settings::{Range, past};
use super::starts::{FOREVER, Part, broken};
use super::{Timelines, narrow};

/// Resource bits that are held by two at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Twice {
    /// The first instant at which any is.
    pub(crate) at: Time,
    /// Those that are then.
    pub(crate) bits: u128,
    /// How long it is until none of them is, or the plan ends.
    pub(crate) ms: i64,
}

impl Timelines {
    pub(crate) fn held_twice(&self) -> Option<Twice> {
        let at =
            self.bits.values().filter_map(|line| twice(line).next()).map(|it| it.from).min()?;
        let held = |at: i64| {
            let lines = self.bits.iter();
            let at_it = move |piece: &Piece| piece.from <= at && at < piece.to;
            lines.filter_map(move |(bit, line)| Some((*bit, twice(line).find(at_it)?.to)))
        };
        let bits = held(at).fold(0, |bits, (bit, _)| bits | 1_u128 << bit);
        let mut until = at;
        while let Some(to) =
            held(until).filter(|(bit, _)| bits >> bit & 1 == 1).map(|(_, to)| to).max()
        {
            until = to;
        }
        let ms = until.min(self.end - 1) - at;
        Some(Twice { at: Time::new(at), bits, ms })
    }

    /// Each named timeline that leaves its range, or one that is asked for: when
    /// first, and by how much then, in its own unit, rounded up.
    pub(crate) fn out_of_range(&self) -> impl Iterator<Item = (&str, Time, i64)> {
        self.named.iter().filter_map(|named| {
            let (at, by) = named.out_of_range(self.now, self.end)?;
            Some((named.name.as_str(), Time::new(at), narrow((by + FINE - 1).div_euclid(FINE))))
        })
    }
}

/// Where a bit is held by more than one.
fn twice(line: &Line) -> impl Iterator<Item = Piece> {
    line.all().into_iter().filter(|piece| piece.value > 1)
}

/// An instant, and in thousandths how far a value is off then.
type Off = (i64, i128);

impl Named {
    fn out_of_range(&self, now: i64, end: i64) -> Option<Off> {
        let off: Vec<Off> = match &self.result {
            Outcome::Set(set) => {
                let points = set.points(now);
                let points: Vec<_> = points.iter().map(|(at, value)| (at.get(), *value)).collect();
                set_off(&points, &self.ranges(), end)
            }
            Outcome::Sum(line) => sum_off(line, &self.ranges(), now),
        };
        let twice = self.holders.iter().flat_map(twice);
        let twice = twice.map(|piece| (piece.from, (piece.value - 1) * FINE));
        // The earliest, and of those the farthest off.
        let all = off.into_iter().chain(twice);
        all.min_by_key(|&(at, by)| (at, core::cmp::Reverse(by)))
    }
}

fn set_off(points: &[(i64, i64)], ranges: &[Range], end: i64) -> Vec<Off> {
    let nexts = points.iter().skip(1).map(|(at, _)| *at).chain([end]);
    let spans = points.iter().zip(nexts);
    let off = spans.flat_map(|(&(at, value), next)| {
        ranges.iter().filter_map(move |range| {
            let from = at.max(range.from);
            let by = past(value, range.min, range.max)?.abs() * FINE;
            (from < next.min(range.to).min(end)).then_some((from, by))
        })
    });
    off.collect()
}

/// For each range, the first instant at which the line is off it.
fn sum_off(line: &Line, ranges: &[Range], now: i64) -> Vec<Off> {
    let all = [Part { from: 0, to: FOREVER, value: 0, slope: 0 }];
    let off = ranges.iter().filter_map(|range| {
        let keep = keep(*range);
        let at = broken(line, &all, keep, now, false)?.first;
        let value = line.pieces(at, at + 1, |_, _| true).next()?.value;
        Some((at, (keep.min - value).max(value - keep.max)))
    });
    off.collect()
}

#[cfg(test)]
mod tests;
