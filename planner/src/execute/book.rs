//! Who is who, and what has become of whom.

use std::collections::BTreeMap;

use faregate_tickets::amount::Microjoules;

use super::{Action, Control};
use crate::plan::{Activity, ActivityId, Kind, Outcome, Plan};
use crate::state::{Ended, Running};
use crate::timed::{Fate, TimedPlan};
use crate::trace::{Unstarted, Why};
use crate::units::{Bytes, Ppm, Time};

pub(super) fn index(plan: &Plan) -> BTreeMap<ActivityId, usize> {
    plan.activities.iter().enumerate().map(|(place, activity)| (activity.id, place)).collect()
}

impl Control {
    pub(super) fn running(&self, id: ActivityId) -> Option<&Running> {
        self.state.running.iter().find(|running| running.id == id)
    }

    pub(super) fn running_mut(&mut self, id: ActivityId) -> Option<&mut Running> {
        self.state.running.iter_mut().find(|running| running.id == id)
    }

    pub(super) fn outcome(&self, id: ActivityId) -> Option<Outcome> {
        self.state.ended.iter().find(|ended| ended.id == id).map(|ended| ended.outcome)
    }

    pub(super) fn is_open(&self, id: ActivityId) -> bool {
        self.outcome(id).is_none() && self.running(id).is_none()
    }

    pub(super) fn is_mandatory(&self, activity: &Activity) -> bool {
        activity.priority >= self.parameters.mandatory_from
    }

    /// Whether the estimated charge is below this part of the capacity.
    pub(super) fn is_below(&self, limit: Ppm) -> bool {
        let charge = i128::from(self.state.charge.get()) * 1_000_000;
        charge < i128::from(limit.get()) * i128::from(self.state.capacity.get())
    }

    /// What runs becomes what has ended.
    pub(super) fn end(&mut self, id: ActivityId, outcome: Outcome, data: Option<Bytes>) {
        let Some(place) = self.state.running.iter().position(|running| running.id == id) else {
            return;
        };
        let running = self.state.running.remove(place);
        let data = data.unwrap_or(running.data);
        let (started, ended) = (Some(running.started), self.now());
        self.state.ended.push(Ended { id, outcome, started, ended, data });
        self.told.remove(&id);
        self.changes_at_end(id);
        if ended < running.ends {
            self.freed = true;
            self.wish(Why::EndedEarly(id));
        }
        if outcome != Outcome::Succeeded {
            self.freed = true;
            self.wish(Why::Outcome(id));
        }
    }

    /// It will not start.
    pub(super) fn give_up(&mut self, id: ActivityId, why: Unstarted) {
        if self.asked.remove(&id).is_some() {
            self.actions.push(Action::Withdraw(id));
        }
        let (outcome, ended) = (Outcome::NotStarted, self.now());
        self.state.ended.push(Ended { id, outcome, started: None, ended, data: Bytes::ZERO });
        self.actions.push(Action::NotStarted(id, why));
        if self.planned.remove(&id).is_some() {
            self.freed = true;
            self.wish(Why::NotStarted(id));
        }
    }

    /// Activities whose last start range is over.
    pub(super) fn close_ranges(&mut self) {
        let closed: Vec<_> = self
            .plan
            .activities
            .iter()
            .filter(|activity| !matches!(activity.kind, Kind::ManualShutdown { .. }))
            .filter(|activity| self.last_start(activity) < self.now() && self.is_open(activity.id))
            .map(|activity| activity.id)
            .collect();
        for id in closed {
            let was_planned = self.planned.contains_key(&id) || self.asked.contains_key(&id);
            let why = if was_planned { Unstarted::RangeClosed } else { Unstarted::NotPlanned };
            self.give_up(id, why);
        }
    }

    /// A dispatch may be a little late, for want of a device that is still made
    /// safe.
    pub(super) fn last_start(&self, activity: &Activity) -> Time {
        let last = activity.starts.iter().map(|range| range.to).max().unwrap_or(Time::ZERO);
        last.after(self.parameters.handover_tolerance)
    }

    /// Manual blocks that have gone by, and the plan's end.
    pub(super) fn end_plan(&mut self) {
        self.end_blocks();
        if self.now() < self.plan.end {
            return;
        }
        self.is_over = true;
        let open: Vec<_> = self.plan.activities.iter().map(|activity| activity.id).collect();
        for id in open {
            if self.is_open(id) {
                self.give_up(id, Unstarted::NotPlanned);
            }
        }
    }

    fn end_blocks(&mut self) {
        let over: Vec<_> = self
            .plan
            .activities
            .iter()
            .filter(|activity| matches!(activity.kind, Kind::ManualShutdown { .. }))
            .filter_map(|activity| Some((activity.id, activity.starts.first()?.from, activity)))
            .filter(|(id, from, activity)| {
                from.after(activity.duration) <= self.state.now && self.is_open(*id)
            })
            .map(|(id, from, _)| (id, from))
            .collect();
        for (id, from) in over {
            let (outcome, started, ended) = (Outcome::Succeeded, Some(from), self.now());
            self.state.ended.push(Ended { id, outcome, started, ended, data: Bytes::ZERO });
            self.planned.remove(&id);
            self.actions.push(Action::BlockOver(id));
        }
    }

    /// The timed plan, with starts that are late pushed to now.
    pub(super) fn with_pushed_starts(&self) -> TimedPlan {
        let mut timed = self.timed.clone();
        for row in &mut timed.rows {
            let Fate::Scheduled(slot) = &mut row.fate else { continue };
            if self.asked.contains_key(&row.id) && slot.start < self.state.now {
                slot.end = self.state.now.after(slot.length());
                slot.start = self.state.now;
            }
        }
        timed
    }

    pub(super) fn estimated(&mut self, charge: Microjoules) {
        self.state.charge = charge.min(self.state.capacity);
        self.estimated_at = self.state.now;
        self.blind = None;
        self.looks_around = false;
        let is_below = self.is_below(self.parameters.soft_min_soc);
        self.below_soft = if is_below { self.below_soft.saturating_add(1) } else { 0 };
        if !is_below {
            self.spent = false;
        }
    }
}
