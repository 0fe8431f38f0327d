//! Aborts: each has its cause, and is revoked and made safe.

use faregate_planner::Parameters;
use faregate_planner::plan::{ActivityId, Kind};
use faregate_planner::trace::{Cause, Happened, Trace};

use super::{Runs, Walk};
use crate::violation::{Rule, Violation};

impl Walk<'_> {
    /// An estimate of the charge: those below the soft limit are counted.
    pub(super) fn estimate(&mut self, charge: i128) {
        self.estimates.push(charge);
        self.estimated_at = self.now;
        let below = self.estimated_below(self.parameters.soft_min_soc, true);
        self.below_soft = if below { self.below_soft + 1 } else { 0 };
    }

    /// Whether the last estimate is below a minimum; not strictly: or at it.
    fn estimated_below(&self, least: faregate_planner::units::Ppm, strictly: bool) -> bool {
        let (Some(charge), Some(capacity)) = (self.estimates.last(), self.capacity()) else {
            return false;
        };
        let (charge, least) = (charge * 1_000_000, i128::from(least.get()) * capacity);
        charge < least || !strictly && charge == least
    }

    fn capacity(&self) -> Option<i128> {
        super::charge::capacity(self.trace)
    }

    /// Whether it could be aborted for this.
    pub(super) fn has_cause(&self, id: ActivityId, runs: &Runs, cause: Cause) -> bool {
        let optional = self.is_optional(id);
        let samples = self.parameters.soft_samples.max(1);
        match cause {
            Cause::Cutoff => self.now >= runs.cutoff,
            Cause::HardLimit => self.estimated_below(self.parameters.hard_min_soc, false),
            Cause::SoftLimit => optional && self.below_soft >= samples,
            Cause::Duration => {
                let grace = match self.activity(id).map(|activity| activity.kind) {
                    Some(Kind::Expanding { .. }) => self.parameters.expansion_grace.get(),
                    _ => 0,
                };
                optional && self.now >= runs.ends + grace
            }
            Cause::ChargeUnknown => self
                .trace
                .charge_holds
                .is_some_and(|holds| self.now >= self.estimated_at.saturating_add(holds.get())),
            Cause::TicketsTaken => !self.activity(id).is_some_and(|activity| activity.pausable),
            Cause::Ordered => true,
        }
    }
}

/// An abort revokes at once, and makes safe after that.
pub(super) fn check(_: &Parameters, trace: &Trace) -> Vec<Violation> {
    let aborts = trace.entries.iter().enumerate().filter_map(|(place, entry)| match entry.what {
        Happened::Aborted { id, .. } => Some((place, entry.at, id)),
        _ => None,
    });
    let wrong = aborts.filter_map(|(place, at, id)| {
        let find = |what: &Happened| trace.entries.iter().position(|entry| entry.what == *what);
        let revoked = find(&Happened::Revoked(id)).map(|i| (i, trace.entries[i].at));
        let safed = trace.entries.iter().rposition(|entry| entry.what == Happened::Safed(id));
        let fault = match (revoked, safed) {
            (None, _) => Some("its tickets were not revoked"),
            (Some((_, revoked)), _) if revoked > at => Some("its tickets were revoked too late"),
            (_, None) => Some("its devices were not made safe"),
            (Some((revoked, _)), Some(safed)) if safed < revoked.max(place) => {
                Some("its devices were made safe before it was aborted")
            }
            _ => None,
        };
        fault.map(|fault| Violation::new(Rule::AbortSafed, Some(id), at.get()).detail(fault))
    });
    wrong.collect()
}
