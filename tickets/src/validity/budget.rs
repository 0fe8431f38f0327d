//! Budgets: what flows while the device is on, integrated exactly.

use super::{Denial, Rule, soonest_end};
use crate::clock::Instant;

/// An amount that flows at a declared rate while the device is on.
///
/// Kept in a unit so fine that the rate for a microsecond is a whole number of
/// it: nothing is ever rounded. `FINE` of them are one of the unit outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Budget<const FINE: u64> {
    total: u64,
    /// Until `since` where the device is on, else altogether.
    used: u64,
    /// Per microsecond, from `since` on; nothing while the device is off.
    rate: u64,
    since: Option<Instant>,
}

impl<const FINE: u64> Budget<FINE> {
    pub(super) const fn new(total: u64) -> Self {
        Self { total: total.saturating_mul(FINE), used: 0, rate: 0, since: None }
    }

    pub(super) fn check(&self, rule: Rule, now: Instant) -> Result<(), Denial> {
        let used = self.used_at(now);
        if used < self.total {
            return Ok(());
        }
        // The least whole amount with which the budget would exceed the use.
        let short_by = whole::<FINE>(used.saturating_sub(self.total)).saturating_add(1);
        Err(Denial { rule, short_by, until: None })
    }

    /// The device is on from now, at this rate.
    pub(super) fn turn_on(&mut self, rate: u64, now: Instant) {
        self.used = self.used_at(now);
        self.rate = rate;
        // Where the clock went back, no time is counted twice and none is lost.
        self.since = Some(self.since.map_or(now, |since| since.max(now)));
    }

    pub(super) fn confirmed_off(&mut self, at: Instant) {
        if self.since.is_some_and(|since| at > since) {
            *self = Self { used: self.used_at(at), rate: 0, since: None, ..*self };
        }
    }

    pub(super) fn look_again_at(&self, now: Instant) -> Option<Instant> {
        let left = self.total.saturating_sub(self.used_at(now));
        if left > 0 && self.rate == 0 {
            return None;
        }
        Some(soonest_end(u128::from(left), self.rate, now))
    }

    pub(super) fn is_used_up(&self, now: Instant) -> bool {
        self.used_at(now) >= self.total
    }

    /// In the unit outside, rounded down.
    pub(super) fn left(&self) -> u64 {
        whole::<FINE>(self.total.saturating_sub(self.used))
    }

    fn used_at(&self, now: Instant) -> u64 {
        let elapsed = self.since.map_or(0, |since| now.since(since).as_micros());
        self.used.saturating_add(self.rate.saturating_mul(elapsed))
    }
}

/// The whole units in so many fine ones, by multiplication: on some targets a
/// division by a constant is a call into a loop.
fn whole<const FINE: u64>(fine: u64) -> u64 {
    const {
        assert!(FINE.is_multiple_of(2), "for odd numbers the reciprocal needs one place more");
    }
    let shift = const { FINE.trailing_zeros() };
    let (places, reciprocal) = const { reciprocal_of(FINE >> FINE.trailing_zeros()) };
    let product = u128::from(fine >> shift) * reciprocal;
    u64::try_from(product >> places).unwrap_or(u64::MAX)
}

/// `1 / odd` in so many binary places, rounded up.
///
/// It is too large by at most one in the last place. What that adds to the
/// product with a number below `2^63` is less than `1 / odd`, which never
/// reaches the next whole number.
const fn reciprocal_of(odd: u64) -> (u32, u128) {
    let places = 64 + odd.ilog2();
    (places, (1 << places) / odd as u128 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers around which a rounded reciprocal would go wrong first.
    fn awkward(fine: u64) -> impl Iterator<Item = u64> {
        let powers = (0..64).map(|bit| 1 << bit);
        let multiples = (0..64).map(move |bit| (u64::MAX >> bit) / fine * fine);
        powers.chain(multiples).flat_map(|n: u64| [n.wrapping_sub(1), n, n.wrapping_add(1)])
    }

    #[test]
    fn multiplying_by_the_reciprocal_is_dividing() {
        for n in awkward(1_000) {
            assert_eq!(whole::<1_000>(n), n / 1_000);
        }
        for n in awkward(1_000_000) {
            assert_eq!(whole::<1_000_000>(n), n / 1_000_000);
        }
    }
}
