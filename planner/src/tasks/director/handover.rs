//! Handover: the next plan takes over, or this one goes on to its end.

use std::sync::Arc;

use super::{Director, NextPlan, NotPlanned};
use crate::execute::{begin_next, with_what_runs};
use crate::plan::{ActivityId, Plan};
use crate::schedule::schedule;
use crate::tasks::Setting;
use crate::tasks::translate::Given;
use crate::timed::TimedPlan;
use crate::units::Time;
use crate::{Problem, State};

impl NextPlan {
    pub(super) const fn of(plan: &Plan) -> Self {
        if plan.next_plan.is_some() { Self::Expected } else { Self::None }
    }
}

impl Director {
    /// The name of the next plan, once, when it is time for it to take over:
    /// [`Director::take_over`] is how it does.
    pub fn wants_next(&mut self, now: Time) -> Option<String> {
        if self.next_plan != NextPlan::Expected || now < self.setting.plan.handover {
            return None;
        }
        self.next_plan = NextPlan::AskedFor;
        self.setting.plan.next_plan.clone()
    }

    /// The next plan takes over. What runs goes on, with its own cutoff, as the
    /// next plan's running set; what has not started is dropped: these
    /// activities. What the manager is to be told comes with the next turn.
    ///
    /// # Errors
    /// Why it cannot: nothing has changed then, and the present plan goes on to
    /// its end.
    pub fn take_over(
        &mut self,
        now: Time,
        next: Result<Arc<Plan>, String>,
    ) -> Result<Vec<ActivityId>, String> {
        self.next_plan = NextPlan::None;
        self.pass(now);
        let next = next?;
        let merged = with_what_runs(&next, &self.setting.plan, &self.state)?;
        self.numbers_are_free(&next)?;
        let (setting, state, timed) = self.tried(merged)?;
        let dropped = self.open();
        self.early.clear();
        (self.setting, self.state, self.timed) = (setting, state, TimedPlan::default());
        self.next_plan = NextPlan::of(&self.setting.plan);
        self.adopt(timed).map_err(|why| NotPlanned::Misfit(why).to_string())?;
        Ok(dropped)
    }

    /// The first timed plan of the next plan, if there is one that can be
    /// executed.
    fn tried(&self, plan: Plan) -> Result<(Setting, State, TimedPlan), String> {
        let setting = Setting { plan: Arc::new(plan), ..self.setting.clone() };
        let mut state = self.state.clone();
        begin_next(&mut state);
        let problem = Problem::new(&setting.plan, &setting.parameters, &state);
        let problem = problem.map_err(|why| NotPlanned::Unfit(why).to_string())?;
        let timed = schedule(&problem, Some(&TimedPlan::default()));
        let (runs, given) = (self.engines(true), self.engines(false));
        let given = Given {
            setting: &setting,
            windows: &state.windows,
            timed: &timed,
            now: state.now,
            runs: &runs,
            given: &given,
        };
        let tasks = given.tasks(&mut self.numbers.clone());
        tasks.map_err(|why| NotPlanned::Misfit(why).to_string())?;
        Ok((setting, state, timed))
    }

    /// Tasks that are no activities have numbers, too.
    fn numbers_are_free(&self, next: &Plan) -> Result<(), String> {
        let taken = |id: &ActivityId| {
            self.live.keys().any(|live| live.get() == id.get() && self.activity(*live).is_none())
        };
        let taken = next.activities.iter().map(|one| one.id).find(taken);
        taken.map_or(Ok(()), |id| Err(format!("the next plan uses the number of a task, {id}")))
    }

    /// What has not started, and leaves the schedule with its plan.
    fn open(&self) -> Vec<ActivityId> {
        let state = &self.state;
        let is_open = |id: &ActivityId| {
            let has_ended = state.ended.iter().any(|one| one.id == *id);
            !has_ended && !state.running.iter().any(|one| one.id == *id)
        };
        self.setting.plan.activities.iter().map(|one| one.id).filter(is_open).collect()
    }
}
