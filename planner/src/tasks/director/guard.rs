//! What must not start yet, and what must not go on.

use faregate_scheduler::manager::Telecommand;
use faregate_scheduler::task::TaskId;

use super::Director;
use super::adopt::start_of;
use crate::plan::{Activity, Condition, Kind};
use crate::state::Running;
use crate::tasks::generated::Generated;
use crate::units::{Ppm, Time};

impl Director {
    /// Tasks that must not start are held, for as long as that is so.
    pub(super) fn hold_and_let_go(&mut self) {
        let waiting: Vec<_> =
            self.live.iter().filter(|(_, live)| !live.started).map(|(id, _)| *id).collect();
        let shutdown = self.next_shutdown();
        for id in waiting {
            let kept_up = shutdown == Some(id) && !self.state.running.is_empty();
            let may = !kept_up && self.activity(id).is_none_or(|one| self.may_start(one));
            if !may && self.held.insert(id) {
                self.orders.push(Telecommand::Hold(id));
            } else if may && self.held.remove(&id) {
                self.orders.push(Telecommand::Resume(id));
            }
        }
    }

    fn may_start(&self, activity: &Activity) -> bool {
        let recovered = !self.spent || activity.marginal.is_zero();
        recovered
            && activity.conditions.iter().all(|one| self.holds(one))
            && !self.uses_what_is_cold(activity)
    }

    /// An unknown variable satisfies nothing.
    fn holds(&self, condition: &Condition) -> bool {
        let value = self.state.variables.get(&condition.name);
        value.is_some_and(|value| (condition.min..=condition.max).contains(value))
    }

    pub(super) fn uses_what_is_cold(&self, activity: &Activity) -> bool {
        activity.zones.iter().any(|zone| self.state.cold.contains(zone))
    }

    /// The shutdown that comes first, of those that are not the ground's: it
    /// waits for what runs longer than planned.
    fn next_shutdown(&self) -> Option<TaskId> {
        let epoch = self.setting.epoch;
        let shutdowns = self.live.iter().filter(|(id, live)| {
            let what = self.numbers.what(**id);
            let manual = |down: &Time| self.blocks().any(|(_, over, _)| over == *down);
            !live.started && matches!(what, Some(Generated::Shutdown(down)) if !manual(down))
        });
        shutdowns.min_by_key(|(_, live)| start_of(epoch, &live.task)).map(|(id, _)| *id)
    }

    /// The ground's own shutdowns that are not over: when they begin, when the
    /// computer is down, and when it is up again.
    fn blocks(&self) -> impl Iterator<Item = (Time, Time, Time)> {
        let gone = |one: &&Activity| self.state.ended.iter().any(|ended| ended.id == one.id);
        self.setting.plan.activities.iter().filter(move |one| !gone(one)).filter_map(|one| {
            let Kind::ManualShutdown { shutdown, .. } = one.kind else { return None };
            let from = one.starts.first()?.from;
            Some((from, from.after(shutdown), from.after(one.duration)))
        })
    }

    /// When the next of the instants comes at which nothing may run any more.
    pub(super) fn last_end(&self) -> Option<Time> {
        let now = self.state.now;
        let ends = self.blocks().map(|(from, ..)| from).chain([self.setting.plan.end]);
        ends.filter(|at| *at > now && !self.state.running.is_empty()).min()
    }

    /// In the ground's own shutdowns and after the plan's end nothing runs,
    /// whatever its own cutoff is: that may be one of the plan before. Nor does
    /// what the charge does not allow.
    pub(super) fn end_what_must_not_run(&mut self) {
        let now = self.state.now;
        let is_down = self.blocks().any(|(from, _, until)| from <= now && now < until);
        let is_over = is_down || now >= self.setting.plan.end;
        let running = self.state.running.iter();
        let over = running.filter(|one| is_over || self.drains_too_much(one));
        let over: Vec<_> = over.filter_map(|one| TaskId::new(one.id.get())).collect();
        for id in over {
            if self.ending.insert(id) {
                self.orders.push(Telecommand::Remove(vec![id]));
            }
        }
    }

    /// At the hard limit whatever draws, and what is optional below the soft one.
    fn drains_too_much(&self, running: &Running) -> bool {
        let mut all = self.setting.plan.activities.iter();
        let Some(activity) = all.find(|one| one.id == running.id) else { return false };
        let parameters = &self.setting.parameters;
        let draws = running.paused.is_none() && !activity.marginal.is_zero();
        let optional = activity.priority < parameters.mandatory_from;
        let soft = optional && self.below_soft >= parameters.soft_samples.max(1);
        draws && (soft || self.is_below(parameters.hard_min_soc))
    }

    /// Whether the estimated charge is below this part of the capacity.
    fn is_below(&self, limit: Ppm) -> bool {
        let charge = i128::from(self.state.charge.get()) * 1_000_000;
        charge < i128::from(limit.get()) * i128::from(self.state.capacity.get())
    }

    /// Since it was below the hard limit, the charge has not come back to the soft
    /// one.
    pub(super) fn judge_charge(&mut self) {
        let parameters = &self.setting.parameters;
        let low = self.is_below(parameters.soft_min_soc);
        self.spent = low && (self.spent || self.is_below(parameters.hard_min_soc));
        self.below_soft = if low { self.below_soft.saturating_add(1) } else { 0 };
    }
}
