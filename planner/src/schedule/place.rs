//! One candidate's turn.

use std::collections::BTreeMap;

use crate::derive::Placement;
use crate::judge::{Broken, Kind, Rest};
use crate::plan::{ActivityId, Dependency, Outcome};
use crate::problem::{Known, Problem, Range};
use crate::search::Effort;
use crate::timed::{Excess, Limit, Reason, Slot};
use crate::timeline::{Claim, Conflict, Intervals, Timelines};
use crate::units::Time;

use super::Pass;

/// What a candidate is tried against.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial<'a> {
    pub(crate) item: usize,
    pub(crate) problem: &'a Problem,
    pub(crate) timelines: &'a Timelines,
    pub(crate) claim: &'a Claim,
}

/// Why a candidate does not start.
#[derive(Clone, Debug)]
pub(crate) enum Why {
    Reason(Reason),
    /// Every start breaks a limit; this is the first that nothing else refuses.
    Limit(i64),
}

impl From<Reason> for Why {
    fn from(reason: Reason) -> Self {
        Self::Reason(reason)
    }
}

impl Pass<'_> {
    /// Places it, or notes why not, as found the first time.
    pub(crate) fn turn(&mut self, item: usize) {
        if self.slots[item].is_some() || !self.problem.items[item].is_candidate() {
            return;
        }
        self.effort.candidates += 1;
        match self.find(item) {
            Ok(slot) => self.place(item, slot),
            Err(why) => {
                // What is in the way costs more than to see that something is.
                if self.says_why && !self.is_reason_true(item) {
                    self.reasons[item] = Some(self.reason(item, why));
                }
                self.failed[item] = self.version;
            }
        }
    }

    /// Places it at this start, if it can start then. Whether it could.
    pub(crate) fn turn_at(&mut self, item: usize, start: Time) -> bool {
        if self.slots[item].is_some() || !self.problem.items[item].is_candidate() {
            return false;
        }
        self.effort.candidates += 1;
        let after = self.after(item).and_then(|earliest| self.group(item).map(|()| earliest));
        let Ok(earliest) = after else { return false };
        let within = (start, start);
        let fits = self.timelines.valid_starts(&self.claims[item], within);
        let fits = fits.intersection(&self.left(item, earliest));
        let optional = !self.problem.items[item].mandatory;
        let mut effort = self.effort;
        let found = self.rest().earliest(item, &fits, optional, &mut effort);
        self.effort = effort;
        if let Some(start) = found {
            self.place(item, self.slot(item, start));
        }
        found.is_some()
    }

    /// Whether there is one from an earlier turn that still is.
    fn is_reason_true(&self, item: usize) -> bool {
        match self.reasons[item] {
            Some(Reason::PriorOut(prior)) => self.problem.items[item]
                .after
                .iter()
                .any(|(at, on)| on.prior == prior && self.slots[*at].is_none()),
            Some(_) => true,
            None => false,
        }
    }

    /// When it can start first.
    pub(crate) fn find(&mut self, item: usize) -> Result<Slot, Why> {
        let earliest = self.after(item)?;
        self.group(item)?;
        let left = self.left(item, earliest);
        let Some(first) = left.first() else {
            let later = self.ranges(item, earliest.max(self.problem.now));
            let none = later.is_empty();
            return Err((if none { Reason::NoRangeLeft } else { Reason::Committed }).into());
        };
        let mut effort = self.effort;
        let leant = self.leant(item, &left);
        let leant = leant.and_then(|some| self.first_fit(&self.trial(item), &some, &mut effort));
        let start = leant.or_else(|| self.first_fit(&self.trial(item), &left, &mut effort));
        self.effort = effort;
        match start {
            Some(start) => Ok(self.slot(item, start)),
            None => Err(Why::Limit(first.get())),
        }
    }

    /// In words for the operator.
    pub(crate) fn reason(&self, item: usize, why: Why) -> Reason {
        match why {
            Why::Reason(reason) => reason,
            Why::Limit(start) => self.in_the_way(item, start),
        }
    }

    /// As it is tried in its turn.
    pub(crate) fn trial(&self, item: usize) -> Trial<'_> {
        let (problem, timelines) = (self.problem, &self.timelines);
        Trial { item, problem, timelines, claim: &self.claims[item] }
    }

    /// The first of these starts that fits.
    pub(crate) fn first_fit(
        &self,
        trial: &Trial<'_>,
        starts: &Intervals,
        effort: &mut Effort,
    ) -> Option<i64> {
        let fit = starts.iter().map(|within| trial.timelines.valid_starts(trial.claim, within));
        let fit = fit.fold(Intervals::none(), |all, some| all.union(&some));
        let rest = Rest { problem: trial.problem, ..self.rest() };
        let optional = !self.problem.items[trial.item].mandatory;
        rest.earliest(trial.item, &fit, optional, effort)
    }

    /// The first range that admits it.
    fn slot(&self, item: usize, start: i64) -> Slot {
        let it = &self.problem.items[item];
        let admits = |range: &Range| range.from <= start && start <= range.to;
        let range = it.ranges.iter().position(admits).unwrap_or(0);
        Slot { start: Time::new(start), end: Time::new(start + it.shortest), range }
    }

    /// From when on its dependencies are satisfied.
    pub(crate) fn after(&self, item: usize) -> Result<i64, Reason> {
        let after = || self.problem.items[item].after.iter();
        for (prior, on) in after() {
            if let Known::Ended { outcome, .. } = self.problem.items[*prior].fate
                && !satisfies(on, outcome)
            {
                return Err(Reason::PriorEnded(on.prior, outcome));
            }
        }
        let is_out = |prior: usize| {
            self.slots[prior].is_none()
                && !matches!(self.problem.items[prior].fate, Known::Ended { .. })
        };
        if let Some((_, on)) = after().find(|(prior, _)| is_out(*prior)) {
            return Err(Reason::PriorOut(on.prior));
        }
        let planned = || after().filter_map(|(prior, on)| Some((self.slots[*prior]?, on)));
        if let Some((_, on)) = planned().find(|(_, on)| !satisfies(on, Outcome::Succeeded)) {
            return Err(Reason::WaitsForOutcome(on.prior));
        }
        Ok(planned().map(|(slot, _)| slot.end.get()).max().unwrap_or(i64::MIN))
    }

    pub(crate) fn group(&self, item: usize) -> Result<(), Reason> {
        let group = self.problem.items[item].group;
        match group.and_then(|group| self.groups[group]) {
            Some(taken) => Err(Reason::GroupTaken(self.id(taken))),
            None => Ok(()),
        }
    }

    pub(crate) fn id(&self, item: usize) -> ActivityId {
        self.problem.plan.activities[item].id
    }

    /// Starts that its ranges, what it depends on and the commit window leave.
    pub(crate) fn left(&self, item: usize, earliest: i64) -> Intervals {
        let is_cleanup = self.problem.items[item].cleanup;
        let from = if is_cleanup { self.problem.now } else { self.from };
        self.ranges(item, earliest.max(from))
    }

    fn ranges(&self, item: usize, from: i64) -> Intervals {
        let ranges = self.problem.items[item].ranges.iter();
        Intervals::of(ranges.map(|range| (Time::new(range.from.max(from)), Time::new(range.to))))
    }

    /// The first limit that blocks a start.
    pub(crate) fn in_the_way(&self, item: usize, start: i64) -> Reason {
        self.all_in_the_way(item, start).pop_first().map_or(Reason::NoRangeLeft, |(_, it)| it)
    }

    /// Every limit that blocks a start: when it is broken by the most, and by
    /// how much then.
    pub(crate) fn all_in_the_way(&self, item: usize, start: i64) -> BTreeMap<Limit, Reason> {
        let it = &self.problem.items[item];
        let slot = Placement { item, start, end: start + it.shortest };
        let mut all = BTreeMap::new();
        for Conflict { limit, at, worst, amount, with } in
            self.timelines.conflicts(&self.claims[item], Time::new(start))
        {
            let at = if matches!(limit, Limit::Resources(_)) { at } else { worst };
            all.insert(limit.clone(), Reason::Limit { limit, at, amount, with });
        }
        for Broken { kind, at, amount } in self.rest().breaks(slot, !it.mandatory) {
            let (limit, at) = (limit(kind), Time::new(at));
            // Of the peak, timelines know what activities have in it: less than
            // the whole, but who they are.
            let with = if limit == Limit::Peak { self.timelines.strongest(at) } else { None };
            if limit != Limit::Computer || !all.contains_key(&limit) {
                all.insert(limit.clone(), Reason::Limit { limit, at, amount, with });
            }
        }
        all
    }

    /// Places it, and notes what it exceeds because it may.
    pub(super) fn place(&mut self, item: usize, slot: Slot) {
        let mandatory = self.problem.items[item].mandatory;
        let handover = self.problem.handover.filter(|_| mandatory);
        let before = handover.map(|at| self.world.charge(at));
        let data = self.too_much_data(item, slot.start).filter(|_| mandatory);
        self.put(item, slot);
        let by = Some(self.id(item));
        if let (Some(at), Some(before)) = (handover, before) {
            let (charge, min) = (self.world.charge(at), self.problem.battery.handover);
            if charge < min && charge < before {
                let at = Time::new(at);
                self.excess.push(Excess { by, limit: Limit::Handover, at, amount: min - charge });
            }
        }
        if let Some(at) = data {
            let total = self.timelines.volumes(at).next().map_or(0, |(_, total)| total);
            let amount = total - self.problem.plan.max_delta_data.get();
            self.excess.push(Excess { by, limit: Limit::Data, at, amount });
        }
    }

    /// When its data exceed the limit first.
    fn too_much_data(&self, item: usize, start: Time) -> Option<Time> {
        let mut claim = self.claims[item].clone();
        claim.limited = claim.data > 0;
        let conflict = self.timelines.conflict(&claim, start)?;
        (conflict.limit == Limit::Data).then_some(conflict.at)
    }
}

fn satisfies(on: &Dependency, outcome: Outcome) -> bool {
    on.statuses.iter().any(|status| status.includes(outcome))
}

const fn limit(kind: Kind) -> Limit {
    match kind {
        Kind::Soft => Limit::SoftMinimum,
        Kind::Handover => Limit::Handover,
        Kind::Peak => Limit::Peak,
        Kind::Computer => Limit::Computer,
        Kind::Lead => Limit::Lead,
    }
}
