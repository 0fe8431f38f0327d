//! How one start breaks a range: when first, and when by the most.

use super::super::line::{Line, Piece};
use super::{Bad, Keep, Part, exceeds, reach};

/// A range is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Breach {
    /// The first instant at which it is.
    pub(crate) first: i64,
    /// The first of those at which it is by the most.
    pub(crate) worst: i64,
    /// By how much then.
    pub(crate) by: i128,
}

impl Breach {
    /// At one instant.
    pub(crate) const fn at(at: i64, by: i128) -> Self {
        Self { first: at, worst: at, by }
    }

    /// Of two the larger one, from the earlier one's first instant on.
    pub(crate) fn and(self, other: Self) -> Self {
        let is_larger = (other.by, self.worst) > (self.by, other.worst);
        let Self { worst, by, .. } = if is_larger { other } else { self };
        Self { first: self.first.min(other.first), worst, by }
    }
}

/// How one start breaks a range; only where it makes things worse, if so asked.
pub(crate) fn broken(
    line: &Line,
    parts: &[Part],
    keep: Keep,
    start: i64,
    worse: bool,
) -> Option<Breach> {
    let both = parts.iter().flat_map(|&part| {
        let parts = if worse { [part.worse(true), part.worse(false)] } else { [Some(part); 2] };
        [over(line, parts[0], keep, start), under(line, parts[1], keep, start)]
    });
    both.flatten().reduce(Breach::and)
}

fn over(line: &Line, part: Option<Part>, keep: Keep, start: i64) -> Option<Breach> {
    let part = part?.bounded(line, (start, start));
    let most = part.value.max(part.last());
    let (from, to) = reach(part, keep, (start, start));
    let pieces = line.pieces(from, to, |_, high| high + most > keep.max);
    excess(pieces.map(|piece| plus(piece, part, start)), keep.max)
}

fn under(line: &Line, part: Option<Part>, keep: Keep, start: i64) -> Option<Breach> {
    let part = part?.bounded(line, (start, start));
    let least = part.value.min(part.last());
    let (from, to) = reach(part, keep, (start, start));
    let pieces = line.pieces(from, to, |low, _| low + least < keep.min);
    let mirrored = pieces.map(|piece| {
        let sum = plus(piece, part, start);
        Piece { value: -sum.value, slope: -sum.slope, ..sum }
    });
    excess(mirrored, keep.min.checked_neg()?)
}

/// What the line has there with the part.
fn plus(piece: Piece, part: Part, start: i64) -> Piece {
    let age = i128::from(piece.from - start - part.from);
    let value = piece.value + part.value + part.slope * age;
    Piece { value, slope: piece.slope + part.slope, ..piece }
}

fn excess(pieces: impl Iterator<Item = Piece>, max: i128) -> Option<Breach> {
    let past = pieces.filter_map(|piece| {
        let (_, high) = piece.bounds();
        let mut from = Bad::new();
        let value = piece.value - piece.slope * i128::from(piece.from);
        exceeds(piece.from, piece.to - 1, value, piece.slope, max, &mut from);
        let worst = if piece.slope > 0 { piece.to - 1 } else { piece.from };
        from.first().map(|&(first, _)| Breach { first, worst, by: high - max })
    });
    past.reduce(Breach::and)
}
