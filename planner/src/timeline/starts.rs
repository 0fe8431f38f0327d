//! Which starts break a limit: exact, by solving for the start.
//!
//! What an activity adds to a line is a shape that moves with its start. Where
//! a straight piece of the shape lies over a straight piece of the line, the
//! largest sum is at an end of what they share; each of the four ends moves in
//! a straight line with the start. So the starts that break a limit are a few
//! intervals for each piece of the line.

use super::line::{Line, Piece};

/// A straight piece of what an activity adds, in ms from its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// Its first instant.
    pub(crate) from: i64,
    /// The first instant that is not in it. `FOREVER`: it stays.
    pub(crate) to: i64,
    /// What it adds at its first instant.
    pub(crate) value: i128,
    /// What each ms adds.
    pub(crate) slope: i128,
}

/// Longer than any plan.
pub(crate) const FOREVER: i64 = i64::MAX;

/// A range that must be kept over some instants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Keep {
    pub(crate) from: i64,
    pub(crate) to: i64,
    pub(crate) min: i128,
    pub(crate) max: i128,
}

/// The first and the last start that are asked for.
pub(crate) type Within = (i64, i64);

impl Part {
    pub(crate) const fn is_something(&self) -> bool {
        self.value != 0 || self.slope != 0
    }

    fn last(&self) -> i128 {
        self.value + self.slope * i128::from(self.to - 1 - self.from)
    }

    /// The part in which it adds, and the part in which it takes away: where it
    /// does neither, it makes nothing worse.
    fn worse(self, up: bool) -> Option<Self> {
        let sign = if up { 1 } else { -1 };
        if self.slope == 0 {
            return (self.value * sign > 0).then_some(self);
        }
        let (first, last) = (self.value * sign, self.last() * sign);
        // The instants from the first one to the last one that lie above 0.
        match (first > 0, last > 0) {
            (true, true) => Some(self),
            (false, false) => None,
            (true, false) => {
                let count = (first - 1).div_euclid(-self.slope * sign) + 1;
                Some(Self { to: self.from + narrow(count), ..self })
            }
            (false, true) => {
                let skip = (-first).div_euclid(self.slope * sign) + 1;
                let value = self.value + self.slope * skip;
                Some(Self { from: self.from + narrow(skip), value, ..self })
            }
        }
    }

    /// Where the end lies at which `FOREVER` can no longer be told from a
    /// number: beyond the line for each start.
    fn bounded(mut self, line: &Line, within: Within) -> Self {
        if self.to == FOREVER {
            let beyond = line.end().saturating_sub(within.0).saturating_add(1);
            self.to = beyond.max(self.from + 1);
        }
        self
    }
}

/// Adds to `bad` the starts at which the line with the shape leaves the range
/// where it makes things worse.
pub(crate) fn worse(line: &Line, parts: &[Part], keep: Keep, within: Within, bad: &mut Bad) {
    for part in parts {
        if let Some(part) = part.worse(true) {
            above(line, part, keep, within, bad);
        }
        if let Some(part) = part.worse(false) {
            below(line, part, keep, within, bad);
        }
    }
}

/// Adds to `bad` the starts at which the line with the shape leaves the range,
/// whoever is to blame.
pub(crate) fn outside(line: &Line, parts: &[Part], keep: Keep, within: Within, bad: &mut Bad) {
    for &part in parts {
        above(line, part, keep, within, bad);
        below(line, part, keep, within, bad);
    }
}

/// Starts that are not valid, as intervals, in no order.
pub(crate) type Bad = Vec<(i64, i64)>;

fn above(line: &Line, part: Part, keep: Keep, within: Within, bad: &mut Bad) {
    if keep.max == i128::MAX {
        return;
    }
    let part = part.bounded(line, within);
    let most = part.value.max(part.last());
    let (from, to) = reach(part, keep, within);
    for piece in line.pieces(from, to, |_, high| high + most > keep.max) {
        solve(piece, part, keep.max, within, bad);
    }
}

fn below(line: &Line, part: Part, keep: Keep, within: Within, bad: &mut Bad) {
    if keep.min == i128::MIN {
        return;
    }
    let part = part.bounded(line, within);
    let least = part.value.min(part.last());
    let mirrored = Part { value: -part.value, slope: -part.slope, ..part };
    let (from, to) = reach(part, keep, within);
    for piece in line.pieces(from, to, |low, _| low + least < keep.min) {
        let piece = Piece { value: -piece.value, slope: -piece.slope, ..piece };
        solve(piece, mirrored, -keep.min, within, bad);
    }
}

/// The instants over which the part can lie, within those that are kept.
fn reach(part: Part, keep: Keep, within: Within) -> (i64, i64) {
    let from = within.0.saturating_add(part.from);
    let to = within.1.saturating_add(part.to);
    (from.max(keep.from), to.min(keep.to))
}

/// The starts at which the sum of the two is above the limit somewhere.
fn solve(piece: Piece, part: Part, limit: i128, within: Within, bad: &mut Bad) {
    let (a, b) = (piece.from, piece.to - 1);
    let (p, q) = (part.from, part.to - 1);
    let (pw, qw) = (i128::from(p), i128::from(q));
    let (k, r) = (piece.slope, part.slope);
    let end = piece.at(b);
    let last = part.value + r * (qw - pw);
    let (aw, bw) = (i128::from(a), i128::from(b));
    // At the piece's begin and end the part is the older, the earlier it
    // started; at the part's begin and end the piece is.
    let ends = [
        (a - q, a - p, piece.value + part.value + r * (aw - pw), -r),
        (b - q, b - p, end + part.value + r * (bw - pw), -r),
        (a - p, b - p, piece.value + k * (pw - aw) + part.value, k),
        (a - q, b - q, piece.value + k * (qw - aw) + last, k),
    ];
    for (first, to, value, slope) in ends {
        exceeds(first.max(within.0), to.min(within.1), value, slope, limit, bad);
    }
}

/// The starts s from `first` to `last` with value + slope * s > limit.
fn exceeds(mut first: i64, mut last: i64, value: i128, slope: i128, limit: i128, bad: &mut Bad) {
    let room = limit - value;
    if slope > 0 {
        first = first.max(narrow(room.div_euclid(slope) + 1));
    } else if slope < 0 {
        // Above as long as s is below room / slope, whose signs are turned.
        last = last.min(narrow((-room - 1).div_euclid(-slope)));
    } else if room >= 0 {
        return;
    }
    if first <= last {
        bad.push((first, last));
    }
}

/// As near as an instant can be.
fn narrow(wide: i128) -> i64 {
    i64::try_from(wide).unwrap_or(if wide < 0 { i64::MIN } else { i64::MAX })
}

mod broken;

pub(crate) use broken::{Breach, broken};

#[cfg(test)]
mod tests;
