//! What is in the way of a start.

use faregate_agents::Categories;

use crate::plan::ActivityId;
use crate::timed::Limit;
use crate::units::Time;

use super::claim::{Claim, FINE};
use super::line::Line;
use super::named::{Named, Outcome, during, keep, one, setter};
use super::settings::Off;
use super::starts::{Keep, Part, broken};
use super::{Limited, Timelines, at_most, bits, narrow};

/// A limit that a start breaks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// Which one.
    pub limit: Limit,
    /// The first instant at which it is broken.
    pub at: Time,
    /// By how much at most: bytes, mW, engines, the timeline's own unit
    /// (rounded up); for bits the ms from then on until they are free.
    pub amount: i64,
    /// Who holds the bits, or is the largest of those that run then; `None`
    /// where it is a window, or where nobody is.
    pub with: Option<ActivityId>,
}

impl Timelines {
    /// The first limit, in their order, that blocks a start; `None` where it is
    /// valid.
    #[must_use]
    pub fn conflict(&self, claim: &Claim, start: Time) -> Option<Conflict> {
        let data = if claim.limited { claim.volume() } else { None };
        let (peak, engines) = (claim.over(claim.peak.into()), claim.over(claim.engines.into()));
        let at = start.get();
        self.sum(Limit::Data, &self.data, data, at, |claim| claim.data.into())
            .or_else(|| self.sum(Limit::Peak, &self.peak, peak, at, |claim| claim.peak.into()))
            .or_else(|| {
                self.sum(Limit::Engines, &self.engines, engines, at, |claim| claim.engines.into())
            })
            .or_else(|| self.held(claim, at))
            .or_else(|| self.named.iter().find_map(|named| self.off_range(named, claim, at)))
    }

    fn sum(
        &self,
        limit: Limit,
        sum: &Limited,
        part: Option<Part>,
        start: i64,
        size: impl Fn(&Claim) -> i128,
    ) -> Option<Conflict> {
        let (at, amount) = broken(&sum.line, part.as_slice(), at_most(sum.max), start, true)?;
        let with = self.running(at).filter(|claim| size(claim) > 0).max_by_key(|claim| size(claim));
        Some(Conflict {
            limit,
            at: Time::new(at),
            amount: narrow(amount),
            with: with.and_then(|claim| claim.id),
        })
    }

    fn held(&self, claim: &Claim, start: i64) -> Option<Conflict> {
        let part = claim.over(1);
        let found = |line: &Line| broken(line, part.as_slice(), at_most(1), start, true);
        let taken = bits(claim).filter_map(|bit| Some((found(self.bits.get(&bit)?)?.0, bit)));
        let (at, _) = taken.min()?;
        let (from, with) = self.under(at).find(|(_, other)| other.bits & claim.bits != 0)?;
        Some(Conflict {
            limit: Limit::Resources(Categories::from_mask(with.bits & claim.bits).mask()),
            at: Time::new(at),
            amount: from.saturating_add(with.length).saturating_sub(at),
            with: with.id,
        })
    }

    fn off_range(&self, named: &Named, claim: &Claim, start: i64) -> Option<Conflict> {
        let touch = claim.named.iter().find(|touch| self.named.get(touch.line) == Some(named))?;
        let off = match &named.result {
            Outcome::Set(set) => set.off(setter(touch, claim), start, &named.ranges()),
            Outcome::Sum(line) => {
                let others = named.ranges().into_iter();
                let others =
                    others.map(|range| broken(line, &touch.parts, keep(range), start, true));
                let own = touch.keep.map(|(min, max)| Keep {
                    from: i64::MIN,
                    to: i64::MAX,
                    min: i128::from(min) * FINE,
                    max: i128::from(max) * FINE,
                });
                let own =
                    own.and_then(|own| broken(line, &during(touch, claim), own, start, false));
                let off = others.chain([own]).flatten().min();
                off.map(|(at, amount)| (at, (amount + FINE - 1).div_euclid(FINE)))
            }
        };
        let unit = named.holders.as_ref().filter(|_| touch.holds);
        let unit = unit.and_then(|line| broken(line, &[one(claim)], at_most(1), start, true));
        let (at, amount): Off = off.or(unit)?;
        let others = self
            .running(at)
            .filter(|other| other.named.iter().any(|theirs| theirs.line == touch.line));
        Some(Conflict {
            limit: Limit::Timeline(named.name.clone()),
            at: Time::new(at),
            amount: narrow(amount),
            with: others.filter_map(|other| other.id).next(),
        })
    }

    /// What is placed over an instant.
    fn running(&self, at: i64) -> impl Iterator<Item = &Claim> {
        self.under(at).map(|(_, claim)| claim)
    }

    /// The same, and since when.
    fn under(&self, at: i64) -> impl Iterator<Item = (i64, &Claim)> {
        let begun = self.placed.range(..=(at, usize::MAX));
        let begun = begun.map(|(&(start, _), claim)| (start, claim));
        begun.filter(move |(start, claim)| at < start.saturating_add(claim.length))
    }
}
