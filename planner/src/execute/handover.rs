//! Handover: the next plan takes over, or this one goes on to its end.

use std::sync::Arc;

use super::{Action, Control, NextPlan, book};
use crate::plan::Plan;
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

    /// The next plan, with the definitions of what runs: it stays, with its own
    /// cutoff.
    pub(super) fn with_what_runs(&self, next: Arc<Plan>) -> Result<Arc<Plan>, String> {
        if next.end <= self.now() {
            return Err("the next plan is over already".to_owned());
        }
        let mut merged = Plan::clone(&next);
        for running in &self.state.running {
            if next.activities.iter().any(|activity| activity.id == running.id) {
                return Err(format!("the next plan uses the number of {}, which runs", running.id));
            }
            merged.activities.extend(self.activity(running.id).cloned());
        }
        Ok(Arc::new(merged))
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
        self.state.ended.clear();
        self.planned.clear();
        self.timed = TimedPlan::default();
        if self.plan.next_plan.is_some() {
            self.next_plan = NextPlan::Expected;
        }
        self.actions.push(Action::HandedOver);
        self.wish(Why::HandOver);
    }
}
