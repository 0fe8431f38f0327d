//! What becomes of each activity: one thing.

use faregate_planner::Plan;
use faregate_planner::plan::{Activity, ActivityId, Kind, Outcome};
use faregate_planner::trace::Cause;

use super::Walk;
use crate::violation::Rule;

impl<'a> Walk<'a> {
    pub(super) fn ends(&mut self, id: ActivityId, outcome: Outcome) {
        // Nobody starts the ground's own shutdown.
        let manual = self.activity(id).is_some_and(is_manual);
        if self.runs.remove(&id).is_none() && !manual {
            self.blame(Rule::Fate, id, "ended without having been started");
        }
        self.fate(id, outcome);
    }

    pub(super) fn not_started(&mut self, id: ActivityId) {
        if self.started.contains(&id) {
            self.blame(Rule::Fate, id, "said not to start although it had");
        }
        self.fate(id, Outcome::NotStarted);
    }

    fn fate(&mut self, id: ActivityId, outcome: Outcome) {
        if self.over.insert(id, outcome).is_some() {
            self.blame(Rule::Fate, id, "its second");
        }
    }

    /// The trace is over: everything has met its fate, or goes on elsewhere.
    pub(super) fn close(&mut self) {
        self.pass(self.trace.end.get());
        self.every_fate(false);
    }

    /// Everything of this plan has met its fate, or goes on.
    fn every_fate(&mut self, goes_on: bool) {
        for activity in &self.plan.activities {
            let manual = is_manual(activity);
            let goes_on = goes_on && self.runs.contains_key(&activity.id);
            if !manual && !goes_on && !self.over.contains_key(&activity.id) {
                self.blame(Rule::Fate, activity.id, "none");
            }
        }
    }

    /// Another plan is executed from now on. What runs stays, and is in it.
    pub(super) fn handed_over(&mut self, next: &'a Plan) {
        self.every_fate(true);
        self.plan = next;
        self.over.clear();
        self.started = self.runs.keys().copied().collect();
    }

    pub(super) fn aborted(&mut self, id: ActivityId, cause: Cause) {
        let Some(runs) = self.runs.remove(&id) else {
            return self.blame(Rule::Fate, id, "aborted without having been started");
        };
        if !self.has_cause(id, &runs, cause) {
            let detail = format!("{cause:?}");
            self.blame(Rule::AbortCause, id, &detail);
        }
        self.fate(id, Outcome::Aborted);
    }
}

const fn is_manual(activity: &Activity) -> bool {
    matches!(activity.kind, Kind::ManualShutdown { .. })
}
