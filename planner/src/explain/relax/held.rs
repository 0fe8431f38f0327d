//! What would have to be given up: resource bits, dependencies.

use crate::plan::ActivityId;
use crate::schedule::place::Trial;
use crate::timed::Limit;
use crate::units::Time;

use super::super::{Change, Number};
use super::{Turn, change};

impl Turn<'_, '_> {
    /// As few bits as it takes: with any of them kept there is no start.
    pub(super) fn resources(&self) -> Option<(Limit, Change)> {
        let own = self.pass.trial(self.item).claim.bits;
        let first = self.without_bits(own)?;
        let bits = (0..128).map(|bit| 1_u128 << bit).filter(|bit| own & bit != 0);
        let needed = bits.fold(own, |needed, bit| {
            if self.without_bits(needed & !bit).is_some() { needed & !bit } else { needed }
        });
        let start = self.without_bits(needed).unwrap_or(first);
        let mut held = self.pass.trial(self.item).claim.clone();
        held.bits = needed;
        let holder = self.pass.timelines.conflicts(&held, Time::new(start));
        let holder = holder.into_iter().find(|it| matches!(it.limit, Limit::Resources(_)));
        let (with, until) = holder.map(|it| (it.with, it.at.get() + it.amount)).unzip();
        let change = Change {
            with: with.flatten(),
            until: until.map(Time::new),
            ..change(Number::Without, (0, start))
        };
        Some((Limit::Resources(needed), change))
    }

    fn without_bits(&self, bits: u128) -> Option<i64> {
        let trial = self.pass.trial(self.item);
        let mut free = trial.claim.clone();
        free.bits &= !bits;
        self.fits(&Trial { claim: &free, ..trial }, &self.left)
    }

    /// Without one of those that it depends on, each by itself.
    pub(super) fn dependencies(&self) -> Vec<Change> {
        let after = &self.pass.problem.items[self.item].after;
        let mut priors: Vec<ActivityId> = after.iter().map(|(_, on)| on.prior).collect();
        priors.sort_unstable();
        priors.dedup();
        let without = |prior| {
            let without = Change { with: Some(prior), ..change(Number::Without, (0, 0)) };
            let start = self.again(&Limit::Dependency, without)?;
            Some(Change { start: Time::new(start), ..without })
        };
        priors.into_iter().filter_map(without).collect()
    }
}
