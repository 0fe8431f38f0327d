//! The duty cycle: on-time that rest earns back.

use core::fmt;

use super::{Ask, Denial, RanOut, Rule, soonest_end};
use crate::clock::{Duration, Instant};
use crate::device::Effect;

/// A bucket that empties in `on` microseconds of use and fills up in `rest`
/// microseconds without.
///
/// It holds `on * rest` drops; use takes `rest` of them per microsecond, and
/// rest gives `on` back. So nothing is ever divided or rounded. The drops need
/// 128 bits: on-times of hours do occur.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct DutyCycle {
    on: u64,
    rest: u64,
    /// As of `since`.
    drops: u128,
    since: Instant,
    is_on: bool,
}

impl DutyCycle {
    pub(super) const fn new(on: Duration, period: Duration) -> Result<Self, NoDutyCycle> {
        let (on, rest) = (on.as_micros(), period.saturating_sub(on).as_micros());
        if on == 0 || rest == 0 {
            return Err(NoDutyCycle);
        }
        Ok(Self { on, rest, drops: drops(on, rest), since: Instant::START, is_on: false })
    }

    pub(super) fn check(&self, now: Instant) -> Result<(), Denial> {
        if self.ran_out(now).is_some() {
            // The rest begins when it is seen off, and that is not known yet.
            return Err(Denial { rule: Rule::DutyCycle, short_by: self.rest, until: None });
        }
        match self.rests_until() {
            Some(until) if now < until => {
                let short_by = until.since(now).as_micros();
                Err(Denial { rule: Rule::DutyCycle, short_by, until: Some(until) })
            }
            _ => Ok(()),
        }
    }

    pub(super) fn commit(&mut self, ask: &Ask<'_>) {
        if let Effect::On { .. } = ask.effect {
            // Where the clock went back, no time is counted twice.
            self.settle(self.since.max(ask.now), true);
        }
    }

    pub(super) fn confirmed_off(&mut self, at: Instant) {
        if self.is_on && at > self.since {
            self.settle(at, false);
        }
    }

    pub(super) fn look_again_at(&self, now: Instant) -> Option<Instant> {
        self.is_on.then(|| soonest_end(self.drops_at(now), self.rest, now))
    }

    pub(super) fn ran_out(&self, now: Instant) -> Option<RanOut> {
        let out = self.is_on && self.drops_at(now) == 0;
        out.then_some(RanOut { rule: Rule::DutyCycle, ends_ticket: false })
    }

    /// The end of the rest of a device that emptied its bucket. Until then it
    /// stays off: a bucket of a few drops would only make it chatter.
    pub(super) fn rests_until(&self) -> Option<Instant> {
        let rests = !self.is_on && self.drops == 0;
        rests.then(|| self.since.after(Duration::from_micros(self.rest)))
    }

    fn settle(&mut self, at: Instant, is_on: bool) {
        *self = Self { drops: self.drops_at(at), since: at, is_on, ..*self };
    }

    fn drops_at(&self, now: Instant) -> u128 {
        let elapsed = now.since(self.since).as_micros();
        if self.is_on {
            self.drops.saturating_sub(drops(elapsed, self.rest))
        } else {
            self.drops.saturating_add(drops(elapsed, self.on)).min(drops(self.on, self.rest))
        }
    }
}

/// A product of two 64-bit numbers always fits in 128 bits.
const fn drops(micros: u64, rate: u64) -> u128 {
    micros as u128 * rate as u128
}

/// A duty cycle of nothing, or of everything, was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NoDutyCycle;

impl fmt::Display for NoDutyCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the on-time of a duty cycle is more than nothing and less than its period")
    }
}

impl core::error::Error for NoDutyCycle {}
