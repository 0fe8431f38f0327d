//! Numbers that depend on by how much a candidate is shifted, and how far it
//! can be shifted until a comparison of them comes out otherwise.
//!
//! A search that tries every millisecond is exact and takes hours; one that
//! assumes that valid starts have no holes is wrong. So each instant and each
//! charge is carried with bounds of how it changes when the candidate comes
//! `x` ms later. Every comparison that the derivation makes at x = 0 then says
//! up to which x it comes out the same; as long as all do, the derivation takes
//! the same path, and what was violated by a margin stays violated until the
//! margin is used up.

/// Slopes are counted in this fraction.
const ONE: i64 = 1 << 16;

/// A number: `at` where the candidate is not shifted, and between
/// `at + lo x - err` and `at + hi x + err` where it is shifted by `x`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Var {
    pub(crate) at: i64,
    lo: i64,
    hi: i64,
    err: i64,
}

impl Var {
    /// A number that does not depend on the candidate.
    pub(crate) const fn fixed(at: i64) -> Self {
        Self { at, lo: 0, hi: 0, err: 0 }
    }

    /// An instant that shifts as the candidate does.
    pub(crate) const fn shifting(at: i64) -> Self {
        Self { at, lo: ONE, hi: ONE, err: 0 }
    }

    pub(crate) const fn is_fixed(self) -> bool {
        self.lo == 0 && self.hi == 0 && self.err == 0
    }

    /// Whether it is exactly `at + slope x`.
    const fn is_exact(self) -> bool {
        self.lo == self.hi && self.err == 0
    }

    /// Sorts by what comes first where it is shifted a little.
    pub(crate) const fn order(self) -> (i64, i64) {
        (self.at, self.lo)
    }

    pub(crate) const fn plus(self, other: Self) -> Self {
        Self {
            at: self.at + other.at,
            lo: self.lo.saturating_add(other.lo),
            hi: self.hi.saturating_add(other.hi),
            err: self.err.saturating_add(other.err),
        }
    }

    pub(crate) const fn minus(self, other: Self) -> Self {
        Self {
            at: self.at - other.at,
            lo: self.lo.saturating_sub(other.hi),
            hi: self.hi.saturating_sub(other.lo),
            err: self.err.saturating_add(other.err),
        }
    }

    pub(crate) const fn later(self, span: i64) -> Self {
        Self { at: self.at + span, ..self }
    }

    pub(crate) const fn times(self, factor: i64) -> Self {
        let at = self.at * factor;
        if self.is_fixed() {
            return Self::fixed(at);
        }
        let (a, b) = (self.lo.saturating_mul(factor), self.hi.saturating_mul(factor));
        let (lo, hi) = if factor < 0 { (b, a) } else { (a, b) };
        Self { at, lo, hi, err: self.err.saturating_mul(factor.saturating_abs()) }
    }

    /// The largest integer that, times `by`, is not more. `by` is positive.
    pub(crate) fn divided(self, by: i64) -> Self {
        let at = self.at.div_euclid(by);
        // A slope that is a multiple leaves what is rounded off unchanged.
        if self.is_exact() && self.lo.rem_euclid(by.saturating_mul(ONE)) == 0 {
            let slope = self.lo.div_euclid(by);
            return Self { at, lo: slope, hi: slope, err: 0 };
        }
        let up = |n: i64| -(-n).div_euclid(by);
        let err = up(self.err).saturating_add(1);
        Self { at, lo: self.lo.div_euclid(by), hi: up(self.hi), err }
    }

    /// The smallest integer that, times `by`, is not less. `by` is positive.
    pub(crate) fn divided_up(self, by: i64) -> Self {
        self.times(-1).divided(by).times(-1)
    }

    /// Some number from `low` to `high`, at present `at`.
    pub(crate) fn between(at: i64, low: Self, high: Self) -> Self {
        let spread = high.at.saturating_sub(low.at);
        Self {
            at,
            lo: low.lo.min(high.lo),
            hi: low.hi.max(high.hi),
            err: spread.saturating_add(low.err.max(high.err)),
        }
    }

    /// A line through a point, at an instant that may shift: `value` there,
    /// `before` mW up to it and `after` from it on. Only its lower bound is
    /// meant.
    pub(crate) fn on_line(value: i64, at: Self, before: i64, after: i64) -> Self {
        if at.is_fixed() {
            return Self::fixed(value);
        }
        if at.is_exact() {
            let slope = if at.lo > 0 { after } else { before };
            let slope = at.lo.saturating_mul(slope);
            return Self { at: value, lo: slope, hi: slope, err: 0 };
        }
        let (down, up) = (after.min(0), before.max(0));
        let right = at.hi.max(0).saturating_mul(down);
        let left = at.lo.saturating_neg().max(0).saturating_mul(up);
        let lo = right.saturating_sub(left);
        let steepest = down.saturating_neg().max(up);
        Self { at: value, lo, hi: i64::MAX, err: at.err.saturating_mul(steepest) }
    }
}

/// How far the candidate can be shifted with every comparison as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reach(i64);

impl Reach {
    /// As far as one likes.
    pub(crate) const ALL: Self = Self(i64::MAX);

    pub(crate) const fn get(self) -> i64 {
        self.0
    }

    pub(crate) fn limit(&mut self, to: i64) {
        self.0 = self.0.min(to.max(0));
    }

    /// Whether `a <= b`.
    pub(crate) fn le(&mut self, a: Var, b: Var) -> bool {
        self.is_kept(b.minus(a))
    }

    /// Whether `a < b`.
    pub(crate) fn lt(&mut self, a: Var, b: Var) -> bool {
        !self.is_kept(a.minus(b))
    }

    /// Whether a margin is not negative.
    pub(crate) fn is_kept(&mut self, margin: Var) -> bool {
        let kept = margin.at >= 0;
        if !margin.is_fixed() {
            if kept { self.while_kept(margin) } else { self.while_broken(margin) }
        }
        kept
    }

    /// As long as a margin that is not negative stays so.
    fn while_kept(&mut self, margin: Var) {
        let left = i128::from(margin.at) - i128::from(margin.err);
        if left < 0 {
            self.0 = 0;
        } else if margin.lo < 0 {
            self.most(left * i128::from(ONE), margin.lo);
        }
    }

    /// As long as a margin that is negative stays so.
    fn while_broken(&mut self, margin: Var) {
        let left = -i128::from(margin.at) - i128::from(margin.err);
        if left <= 0 {
            self.0 = 0;
        } else if margin.hi > 0 {
            self.most(left * i128::from(ONE) - 1, margin.hi);
        }
    }

    /// At most as often as a step, whatever its sign, goes into what is left.
    /// Nearly all the time it goes more often than is asked, and there need be
    /// no division.
    fn most(&mut self, left: i128, step: i64) {
        let step = i128::from(step).abs();
        if (i128::from(self.0) + 1) * step > left {
            self.limit(i64::try_from(left / step).unwrap_or(i64::MAX));
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Some numbers as functions of x, and the same as a `Var`.
    fn value(a: i64, n: i64, d: i64, x: i64) -> i64 {
        (a + n * x).div_euclid(d)
    }

    proptest! {
        /// Comparisons of shifted, scaled and divided numbers come out the same
        /// up to the reach.
        #[test]
        fn within_the_reach_every_comparison_stays(
            a in -200_i64..200, n in -7_i64..7, d in 1_i64..6, b in -100_i64..100, k in -3_i64..3,
        ) {
            let shifted = Var::shifting(0).times(n).plus(Var::fixed(a)).divided(d);
            let other = Var::shifting(b).times(k);
            let mut reach = Reach::ALL;
            let at_0 = reach.le(shifted, other);
            for x in 0..=reach.get().min(500) {
                let holds = value(a, n, d, x) <= (b + x) * k;
                prop_assert_eq!(holds, at_0, "x = {}", x);
            }
        }

        /// The reach is not needlessly short where nothing is rounded.
        #[test]
        fn an_exact_comparison_changes_right_after_the_reach(
            a in -200_i64..200, n in -7_i64..7, b in -100_i64..100,
        ) {
            let shifted = Var::shifting(0).times(n).plus(Var::fixed(a));
            let mut reach = Reach::ALL;
            let at_0 = reach.le(shifted, Var::fixed(b));
            if reach != Reach::ALL {
                let x = reach.get() + 1;
                prop_assert_eq!(value(a, n, 1, x) <= b, !at_0);
            }
        }
    }
}
