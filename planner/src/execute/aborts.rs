//! What must not go on (slide "The planner aborts an activity when").

use super::{Action, Control};
use crate::plan::{Activity, Kind};
use crate::state::Running;
use crate::trace::Cause;

impl Control {
    /// What has run its time may have ended at this very instant: that is judged
    /// when everything that happened at it is known.
    pub(super) fn abort_what_must_not_go_on(&mut self, all_is_said: bool) {
        if all_is_said {
            self.tell_to_end();
        }
        if self.is_below(self.parameters.hard_min_soc) {
            self.spent = true;
        }
        let aborted: Vec<_> = self
            .state
            .running
            .iter()
            .filter_map(|running| Some((running.id, self.cause(running, all_is_said)?)))
            .collect();
        for (id, cause) in aborted {
            self.abort(id, cause);
        }
    }

    fn cause(&self, running: &Running, all_is_said: bool) -> Option<Cause> {
        let activity = self.activity(running.id)?;
        let (now, runs) = (self.state.now, running.paused.is_none());
        let optional = !self.is_mandatory(activity);
        let draws = runs && !activity.marginal.is_zero();
        if all_is_said && now >= running.cutoff.min(self.plan.end) {
            Some(Cause::Cutoff)
        } else if self.block_now().is_some() {
            // The ground wants the computer off.
            Some(Cause::Ordered)
        } else if draws && self.is_below(self.parameters.hard_min_soc) {
            Some(Cause::HardLimit)
        } else if draws && self.blind.is_some() {
            Some(Cause::ChargeUnknown)
        } else if optional && draws && self.below_soft >= self.parameters.soft_samples.max(1) {
            Some(Cause::SoftLimit)
        } else if all_is_said && optional && runs && now >= self.patience(activity, running) {
            Some(Cause::Duration)
        } else {
            None
        }
    }

    /// How long an optional activity may run: one that was told to end has a
    /// grace.
    pub(super) fn patience(&self, activity: &Activity, running: &Running) -> crate::units::Time {
        match activity.kind {
            Kind::Expanding { .. } => running.ends.after(self.parameters.expansion_grace),
            _ => running.ends,
        }
    }

    fn tell_to_end(&mut self) {
        let now = self.now();
        let over: Vec<_> = self
            .state
            .running
            .iter()
            .filter(|running| running.paused.is_none() && now >= running.ends)
            .filter(|running| self.is_expanding(running) && !self.told.contains(&running.id))
            .map(|running| running.id)
            .collect();
        for id in over {
            self.told.insert(id);
            self.actions.push(Action::TellToEnd(id));
        }
    }

    pub(super) fn is_expanding(&self, running: &Running) -> bool {
        let activity = self.activity(running.id);
        activity.is_some_and(|activity| matches!(activity.kind, Kind::Expanding { .. }))
    }
}
