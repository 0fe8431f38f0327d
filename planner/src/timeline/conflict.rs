//! What is in the way of a start.

use faregate_agents::Categories;

use crate::plan::ActivityId;
use crate::timed::Limit;
use crate::units::Time;

use super::claim::{Claim, FINE, Touch};
use super::line::Line;
use super::named::{Outcome, during, keep, one, setter};
use super::starts::{Breach, Keep, Part, broken};
use super::{Limited, Timelines, at_most, bits, narrow};

/// A limit that a start breaks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// Which one.
    pub limit: Limit,
    /// The first instant at which it is broken.
    pub at: Time,
    /// The first instant at which it is broken by the most.
    pub worst: Time,
    /// By how much then: bytes, mW, engines, the timeline's own unit (rounded
    /// up); for bits the ms from the first instant on until they are free.
    pub amount: i64,
    /// Who holds the bits, or is the largest of those that run at the worst
    /// instant; `None` where it is a window, or where nobody is.
    pub with: Option<ActivityId>,
}

impl Timelines {
    /// The first limit, in their order, that blocks a start; `None` where it is
    /// valid.
    #[must_use]
    pub fn conflict(&self, claim: &Claim, start: Time) -> Option<Conflict> {
        self.conflicts(claim, start).next()
    }

    /// All limits, in their order, that block a start.
    pub fn conflicts(&self, claim: &Claim, start: Time) -> impl Iterator<Item = Conflict> {
        let at = start.get();
        let sums = [Limit::Data, Limit::Peak, Limit::Engines].into_iter();
        let sums = sums.filter_map(move |limit| self.sum(limit, claim, at));
        let held = core::iter::once_with(move || self.held(claim, at)).flatten();
        let named = claim.named.iter().filter_map(move |touch| self.off_range(touch, claim, at));
        sums.chain(held).chain(named)
    }

    fn sum(&self, limit: Limit, claim: &Claim, start: i64) -> Option<Conflict> {
        type Size = fn(&Claim) -> i128;
        let (sum, part, size): (&Limited, Option<Part>, Size) = match limit {
            Limit::Data => {
                let part = if claim.limited { claim.volume() } else { None };
                (&self.data, part, |claim| claim.data.into())
            }
            Limit::Peak => (&self.peak, claim.over(claim.peak.into()), |claim| claim.peak.into()),
            Limit::Engines => {
                (&self.engines, claim.over(claim.engines.into()), |claim| claim.engines.into())
            }
            _ => return None,
        };
        let breach = broken(&sum.line, part.as_slice(), at_most(sum.max), start, true)?;
        let beside = self.running(breach.worst).filter(|claim| size(claim) > 0);
        let with = beside.max_by_key(|claim| size(claim)).and_then(|claim| claim.id);
        Some(conflict(limit, breach, with))
    }

    fn held(&self, claim: &Claim, start: i64) -> Option<Conflict> {
        let part = claim.over(1);
        let found = |line: &Line| broken(line, part.as_slice(), at_most(1), start, true);
        let taken = bits(claim).filter_map(|bit| Some(found(self.bits.get(&bit)?)?.first));
        let at = taken.min()?;
        let (from, with) = self.under(at).find(|(_, other)| other.bits & claim.bits != 0)?;
        let limit = Limit::Resources(Categories::from_mask(with.bits & claim.bits).mask());
        let until = from.saturating_add(with.length).saturating_sub(at);
        Some(conflict(limit, Breach::at(at, until.into()), with.id))
    }

    fn off_range(&self, touch: &Touch, claim: &Claim, start: i64) -> Option<Conflict> {
        let named = self.named.get(touch.line)?;
        let off = match &named.result {
            Outcome::Set(set) => {
                let ranges = named.ranges();
                let off = set.off(setter(touch, claim), start, &ranges);
                off.map(|(at, by)| Breach::at(at, by)).reduce(Breach::and)
            }
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
                let off = others.chain([own]).flatten().reduce(Breach::and);
                off.map(|off| Breach { by: (off.by + FINE - 1).div_euclid(FINE), ..off })
            }
        };
        let unit = named.holders.as_ref().filter(|_| touch.holds);
        let unit = unit.and_then(|line| broken(line, &[one(claim)], at_most(1), start, true));
        let breach = off.or(unit)?;
        let others = self
            .running(breach.worst)
            .filter(|other| other.named.iter().any(|theirs| theirs.line == touch.line));
        let with = others.filter_map(|other| other.id).next();
        Some(conflict(Limit::Timeline(named.name.clone()), breach, with))
    }

    /// The activity with the highest peak of those that are placed over an
    /// instant.
    pub(crate) fn strongest(&self, at: Time) -> Option<ActivityId> {
        let running = self.running(at.get()).filter(|claim| claim.peak > 0);
        running.filter(|claim| claim.id.is_some()).max_by_key(|claim| claim.peak)?.id
    }

    /// What is placed over an instant.
    fn running(&self, at: i64) -> impl Iterator<Item = &Claim> {
        self.under(at).map(|(_, claim)| claim)
    }

    /// The same, and since when.
    fn under(&self, at: i64) -> impl Iterator<Item = (i64, &Claim)> {
        let first = at.saturating_sub(self.longest.0);
        let begun = self.placed.range((first, 0)..=(at, usize::MAX));
        let begun = begun.map(|(&(start, _), claim)| (start, claim));
        begun.filter(move |(start, claim)| at < start.saturating_add(claim.length))
    }
}

fn conflict(limit: Limit, breach: Breach, with: Option<ActivityId>) -> Conflict {
    let (at, worst) = (Time::new(breach.first), Time::new(breach.worst));
    Conflict { limit, at, worst, amount: narrow(breach.by), with }
}
