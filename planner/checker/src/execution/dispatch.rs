//! An activity starts: may it?

use faregate_planner::plan::{Activity, Kind, Outcome};
use faregate_planner::state::Mode;
use faregate_planner::trace::{Dispatch, Truth};

use super::{Runs, Walk};
use crate::violation::{Rule, Violation};

impl Walk<'_> {
    pub(super) fn dispatched(&mut self, dispatch: &Dispatch) {
        let id = dispatch.id;
        let Some(activity) = self.activity(id) else {
            return self.blame(Rule::Fate, id, "there is no such activity");
        };
        if self.started.contains(&id) || self.over.contains_key(&id) {
            self.blame(Rule::Fate, id, "started a second time, or after its fate");
        }
        self.range(activity, dispatch);
        self.after(activity);
        self.group(activity);
        self.beside(activity);
        self.zones(activity, dispatch);
        self.looked_at(activity, dispatch);
        if self.mode != Mode::Awake {
            self.blame(Rule::DispatchedAwake, id, "when it was dispatched");
        }
        let range = activity.starts.get(dispatch.range);
        let cutoff = range.map_or(self.plan.end, |range| range.cutoff.min(self.plan.end)).get();
        self.runs.insert(id, Runs { cutoff, ends: dispatch.ends.get(), paused: None });
        self.started.push(id);
    }

    /// It may be late by what making devices safe takes.
    fn range(&mut self, activity: &Activity, dispatch: &Dispatch) {
        let tolerance = self.parameters.handover_tolerance.get();
        let inside = activity.starts.get(dispatch.range).is_some_and(|range| {
            range.from.get() <= self.now && self.now <= range.to.get() + tolerance
        });
        if !inside {
            self.blame(Rule::Dispatched, activity.id, "");
        }
    }

    fn after(&mut self, activity: &Activity) {
        for dependency in &activity.after {
            let outcome = self.over.get(&dependency.prior).copied();
            let right = |outcome| dependency.statuses.iter().any(|s| s.includes(outcome));
            if !outcome.is_some_and(right) {
                let detail = format!("{}: {outcome:?}", dependency.prior);
                self.blame(Rule::DispatchedAfter, activity.id, &detail);
            }
        }
        let went_wrong = |outcome: &&Outcome| matches!(outcome, Outcome::Failed | Outcome::Aborted);
        let priors = activity.after.iter().filter_map(|d| self.over.get(&d.prior));
        if activity.kind == Kind::Cleanup && !priors.into_iter().any(|o| went_wrong(&o)) {
            self.blame(Rule::CleanupAfter, activity.id, "");
        }
    }

    fn group(&mut self, activity: &Activity) {
        let Some(group) = &activity.group else { return };
        let started = self.started.iter().filter_map(|id| self.activity(*id));
        let mut others = started.filter(|a| a.id != activity.id && a.group.as_ref() == Some(group));
        if let Some(other) = others.next() {
            let detail = other.id.to_string();
            self.blame(Rule::RanGroup, activity.id, &detail);
        }
    }

    /// Bits and engines, with what runs and open windows. Whoever is paused lost
    /// its tickets, and with them both.
    fn beside(&mut self, activity: &Activity) {
        let working = self.runs.iter().filter(|(_, runs)| runs.paused.is_none());
        let working = working.filter_map(|(id, _)| self.activity(*id));
        let windows = self.windows.iter().filter_map(|index| self.trace.windows.get(*index));
        let (working, windows): (Vec<_>, Vec<_>) = (working.collect(), windows.collect());
        let shares = working.iter().any(|other| other.resources.overlaps(activity.resources))
            || windows.iter().any(|window| window.resources.overlaps(activity.resources));
        let engines = working.iter().map(|other| u64::from(other.engines)).sum::<u64>()
            + windows.iter().map(|window| u64::from(window.engines)).sum::<u64>();
        let (mine, most) = (u64::from(activity.engines), u64::from(self.parameters.engines));
        if shares {
            self.blame(Rule::RanResources, activity.id, "");
        }
        if mine > 0 && engines + mine > most {
            let violation = Violation::new(Rule::RanEngines, Some(activity.id), self.now);
            self.say(violation.by(engines + mine - most));
        }
    }

    /// Each zone is warm by its estimate; in truth, it may be colder by what the
    /// estimate can be wrong.
    fn zones(&mut self, activity: &Activity, dispatch: &Dispatch) {
        for zone in &activity.zones {
            let seen = dispatch.zones.iter().find(|seen| &seen.zone == zone);
            let warm = seen.is_some_and(|seen| seen.ok && seen.truly + seen.margin >= seen.needed);
            if !warm {
                self.blame(Rule::DispatchedWarm, activity.id, zone);
            }
        }
    }

    /// An unknown variable is not as it should be.
    fn looked_at(&mut self, activity: &Activity, dispatch: &Dispatch) {
        for condition in &activity.conditions {
            let fits = |value: i64| (condition.min..=condition.max).contains(&value);
            let seen = dispatch.variables.iter().find(|(name, _)| *name == condition.name);
            let seen = seen.and_then(|(_, value)| *value);
            let truly = self.variables.get(&condition.name).copied();
            if !seen.is_some_and(fits) || !truly.is_some_and(fits) {
                self.blame(Rule::DispatchedVariables, activity.id, &condition.name);
            }
        }
    }

    /// The truth about power and engines. What nobody decides, a window, may be
    /// too much by itself.
    pub(super) fn truth(&mut self, truth: &Truth) {
        let over = i128::from(truth.peak.get()) - i128::from(self.parameters.peak_limit.get());
        if over > 0 && !self.runs.is_empty() {
            self.say(Violation::new(Rule::RanPeak, None, self.now).by(over));
        }
        let engines = truth.engines.saturating_sub(self.parameters.engines);
        if engines > 0 && !self.runs.is_empty() {
            self.say(Violation::new(Rule::RanEngines, None, self.now).by(engines));
        }
    }
}
