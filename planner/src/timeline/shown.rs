//! Results for people and files: points instead of pieces.

use crate::units::Time;

use super::claim::FINE;
use super::line::{Line, Piece, Ramp};
use super::named::Outcome;
use super::{Timelines, narrow};

/// Values at instants, in order; of two at one instant the later one holds
/// from then on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shown {
    /// Whether values change at once, and not in straight lines from point to
    /// point.
    pub steps: bool,
    /// The points. Values are rounded down.
    pub points: Vec<(Time, i64)>,
}

/// A result on its own: a sum of what is drawn over times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Total(Line);

impl Total {
    /// The same value from one instant to another, both inclusive.
    #[must_use]
    pub fn new(from: Time, to: Time, value: i128) -> Self {
        let (from, to) = (from.get(), to.get());
        Self(Line::new(from, to.max(from).saturating_add(1), value))
    }

    /// So much more in [from, to).
    pub fn add(&mut self, from: Time, to: Time, amount: i128) {
        self.0.add(from.get(), from.get(), to.get(), Ramp { value: amount, slope: 0 });
    }

    /// From when to when, how much: in order, without gaps.
    pub fn steps(&self) -> impl Iterator<Item = (Time, Time, i128)> {
        let pieces = self.0.all().into_iter();
        pieces.map(|piece| (Time::new(piece.from), Time::new(piece.to), piece.value))
    }

    /// As points.
    #[must_use]
    pub fn shown(&self) -> Shown {
        shown(&self.0, 1)
    }
}

impl Timelines {
    /// The data on board, in bytes.
    #[must_use]
    pub fn data(&self) -> Shown {
        shown(&self.data.line, 1)
    }

    /// The sequence engines in use.
    #[must_use]
    pub fn engines(&self) -> Shown {
        shown(&self.engines.line, 1)
    }

    /// The named timelines, in the order of the parameters.
    pub fn named(&self) -> impl Iterator<Item = (&str, Shown)> {
        self.named.iter().map(|named| {
            let values = match &named.result {
                Outcome::Sum(line) => shown(line, FINE),
                Outcome::Set(set) => Shown { steps: true, points: set.points(self.now) },
            };
            (named.name.as_str(), values)
        })
    }
}

fn shown(line: &Line, unit: i128) -> Shown {
    let pieces = line.all();
    let steps = pieces.iter().all(|piece| piece.slope == 0);
    let ends = |piece: &Piece| {
        let point = |at| (Time::new(at), narrow(piece.at(at).div_euclid(unit)));
        // The last instant of all is one before the line's end.
        let to = if piece.to == line.end() { piece.to - 1 } else { piece.to };
        [point(piece.from), point(to)].into_iter().take(if steps { 1 } else { 2 })
    };
    let mut points: Vec<_> = pieces.iter().flat_map(ends).collect();
    points.dedup();
    Shown { steps, points }
}
