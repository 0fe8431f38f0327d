//! The soft minimum: at no instant is the charge below it and lower than
//! without the candidate.

use crate::derive::var::{Reach, Var};
use crate::energy::Segment;

use super::{Kind, Look};

impl Look<'_> {
    pub(super) fn soft(&mut self, segment: &Segment, reach: &mut Reach) {
        let soft = self.problem.battery.soft;
        if segment.first.at >= soft && segment.last.at >= soft {
            if self.keep {
                let _ = reach.is_kept(segment.first.later(-soft));
                let _ = reach.is_kept(segment.last.later(-soft));
            }
            return;
        }
        let Some((first, last)) = self.below(segment) else {
            return self.must_not_move(segment, reach);
        };
        let Some(worst) = self.worse(segment, first, last) else {
            return self.must_not_move(segment, reach);
        };
        let shift = [
            self.stays_worse(segment.from, segment.first),
            self.stays_worse(segment.to, segment.last),
            self.stays_worse_at(segment, worst),
        ];
        let shift = shift.into_iter().max().unwrap_or(0);
        self.breaks(shift, reach);
    }

    /// From when to when the charge is below the minimum, both inclusive. It
    /// is not cut off there.
    fn below(&self, segment: &Segment) -> Option<(i64, i64)> {
        let (from, to) = (segment.from.at, segment.to.at);
        let over = segment.first.at - self.problem.battery.soft;
        let (first, last) = match segment.net {
            0 => (from, to),
            net if net < 0 => (from + (over.div_euclid(-net) + 1).max(0), to),
            net => (from, to.min(from + (-over - 1).div_euclid(net))),
        };
        (first <= last).then_some((first, last))
    }

    /// Where the charge is lowest in comparison with the world without the
    /// candidate, if it is lower anywhere.
    fn worse(&mut self, segment: &Segment, first: i64, last: i64) -> Option<i64> {
        let world = self.world;
        let charge = |at: i64| segment.first.at + segment.net * (at - segment.from.at);
        let less = |piece: usize, at: i64| world.charge_in(piece, at) - charge(at);
        let mut worst: Option<(i64, i64)> = None;
        for piece in world.at(first)..=world.at(last) {
            let from = first.max(world.pieces[piece].from);
            let to = last.min(world.until(piece));
            let (a, b) = world.cut(piece).unwrap_or((from, to));
            for at in [from, a.clamp(from, to), b.clamp(from, to), to] {
                let by = less(piece, at);
                if by > 0 && worst.is_none_or(|(_, most)| by > most) {
                    worst = Some((at, by));
                }
                if by > 0 && self.lists {
                    let is_worse = |at: i64| less(piece, at) > 0;
                    for at in [first_worse(from, at, is_worse), last_worse(at, to, is_worse)] {
                        self.lists(Kind::Soft, at, self.problem.battery.soft - charge(at));
                    }
                }
            }
        }
        worst.map(|(at, _)| at)
    }

    /// By how much it can be shifted so that the charge at an end of the
    /// segment, which may move, is below the minimum and lower than without it.
    /// Negative: it is not.
    fn stays_worse(&self, at: Var, charge: Var) -> i64 {
        let soft = self.problem.battery.soft;
        let piece = self.world.at(at.at);
        let value = self.world.charge_in(piece, at.at);
        if charge.at >= soft || charge.at >= value {
            return -1;
        }
        let mut here = Reach::ALL;
        let _ = here.is_kept(charge.later(-soft));
        let mut other = Var::fixed(value);
        if !at.is_fixed() {
            let it = &self.world.pieces[piece];
            let before = if it.from < at.at { piece } else { piece.saturating_sub(1) };
            let cut = self.world.cut(piece);
            let to = cut
                .filter(|_| value < self.capacity())
                .map_or(self.world.until(piece), |cut| cut.0);
            let from = self.world.pieces[before].from;
            let from = match self.world.cut(before) {
                Some((_, cut)) if value == self.capacity() => from.max(cut.min(at.at)),
                _ => from,
            };
            let _ = here.le(at, Var::fixed(to));
            let _ = here.le(Var::fixed(from), at);
            let flat = |piece: usize| match self.world.cut(piece) {
                Some(_) if value == self.capacity() => 0,
                _ => self.world.pieces[piece].net,
            };
            other = Var::on_line(value, at, flat(before), flat(piece));
        }
        let _ = here.is_kept(charge.minus(other));
        here.get()
    }

    /// The same at an instant in it that does not move.
    fn stays_worse_at(&self, segment: &Segment, at: i64) -> i64 {
        let instant = Var::fixed(at);
        let charge = segment.first.plus(instant.minus(segment.from).times(segment.net));
        let mut here = Reach::ALL;
        let _ = here.le(segment.from, instant);
        let _ = here.le(instant, segment.to);
        let bound = self.problem.battery.soft.min(self.world.charge(at));
        let _ = here.is_kept(charge.later(-bound));
        here.get()
    }

    const fn capacity(&self) -> i64 {
        self.problem.battery.capacity
    }
}

/// The first instant at which it holds, where it holds from some instant on up
/// to `to`.
fn first_worse(from: i64, to: i64, holds: impl Fn(i64) -> bool) -> i64 {
    let (mut low, mut high) = (from, to);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// The last instant at which it holds, where it holds from `from` up to it.
fn last_worse(from: i64, to: i64, holds: impl Fn(i64) -> bool) -> i64 {
    let (mut low, mut high) = (from, to);
    while low < high {
        let middle = low + (high - low + 1) / 2;
        if holds(middle) { low = middle } else { high = middle - 1 }
    }
    low
}
