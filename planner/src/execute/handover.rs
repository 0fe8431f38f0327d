//! Handover: the next plan takes over, or this one goes on to its end.

use std::sync::Arc;

use super::{Action, Control, NextPlan, book};
use crate::plan::{Activity, Plan};
use crate::state::State;
use crate::timed::TimedPlan;
use crate::trace::{Unstarted, Why};

impl Control {
    pub(super) fn take_over(&mut self) {
        if self.next_plan != NextPlan::Expected || self.now() < self.plan.handover {
            return;
        }
        self.next_plan = NextPlan::None;
        if let Some(name) = self.plan.next_plan.clone() {
            self.next_plan = NextPlan::AskedFor;
            self.actions.push(Action::LoadNext(name));
        }
    }

    pub(super) fn hand_over_to(&mut self, next: Arc<Plan>) {
        let open: Vec<_> = self.plan.activities.iter().map(|activity| activity.id).collect();
        for id in open {
            if self.is_open(id) {
                self.withdraw(id);
                self.actions.push(Action::NotStarted(id, Unstarted::HandedOver));
            }
        }
        self.plan = next;
        self.index = book::index(&self.plan);
        begin_next(&mut self.state);
        self.planned.clear();
        self.timed = TimedPlan::default();
        if self.plan.next_plan.is_some() {
            self.next_plan = NextPlan::Expected;
        }
        self.is_untimed = true;
        self.actions.push(Action::HandedOver);
        self.wish(Why::HandOver);
    }
}

/// The next plan, with the definitions of what runs: it stays, with its own
/// cutoff.
///
/// # Errors
/// Why it cannot take over.
pub(crate) fn with_what_runs(next: &Plan, plan: &Plan, state: &State) -> Result<Plan, String> {
    if next.end <= state.now {
        return Err("the next plan is over already".to_owned());
    }
    if next.next_plan.is_some() && next.handover <= state.now {
        // A plan that names itself would take over for ever.
        return Err("the next plan is to be handed over already".to_owned());
    }
    let mut merged = next.clone();
    for running in &state.running {
        if next.activities.iter().any(|activity| activity.id == running.id) {
            return Err(format!("the next plan uses the number of {}, which runs", running.id));
        }
        let known = plan.activities.iter().find(|activity| activity.id == running.id);
        // What it depended on is in the plan before, and so is its group.
        let known = known.cloned().map(|one| Activity { after: Vec::new(), group: None, ..one });
        merged.activities.extend(known);
    }
    Ok(merged)
}

/// What has ended is not the next plan's: neither outcomes nor data.
pub(crate) fn begin_next(state: &mut State) {
    let now = state.now;
    state.ended.clear();
    state.windows.retain(|window| window.end > now);
}
