//! Planned starts that have come.

use super::{Action, Asked, Control, Start};
use crate::plan::{Activity, ActivityId};
use crate::state::Running;
use crate::timed::Slot;
use crate::trace::Why;
use crate::units::{Bytes, Time};

impl Control {
    /// The most important first: it gets its tickets first.
    pub(super) fn dispatch(&mut self) {
        for (id, slot) in self.due_in_order() {
            let ready = self.ready(id, slot, false);
            let is_asked = self.asked.contains_key(&id);
            match ready {
                Ok(_) if !is_asked => self.ask(id, false),
                // What has come between its request and its grant.
                Err(_) if is_asked => self.withdraw(id),
                Ok(_) | Err(_) => {}
            }
        }
        self.withdraw_late_early_ones();
    }

    pub(super) fn ask(&mut self, id: ActivityId, early: bool) {
        self.asked.insert(id, Asked { since: self.now(), early });
        self.actions.push(Action::Request(id));
    }

    /// Who was to start before its time, and did not get its tickets in time,
    /// waits for its time.
    fn withdraw_late_early_ones(&mut self) {
        let now = self.now();
        let tolerance = self.parameters.handover_tolerance;
        let late: Vec<_> = self
            .asked
            .iter()
            .filter(|(id, asked)| {
                asked.early && !self.is_due(**id) && now.since(asked.since) > tolerance
            })
            .map(|(id, _)| *id)
            .collect();
        for id in late {
            self.withdraw(id);
        }
    }

    fn due_in_order(&self) -> Vec<(ActivityId, Slot)> {
        let due = |(_, slot): &(ActivityId, Slot)| slot.start <= self.state.now;
        let planned = self.planned.iter().map(|(id, slot)| (*id, *slot)).filter(due);
        self.by_importance(planned.collect())
    }

    pub(super) fn by_importance(
        &self,
        mut slots: Vec<(ActivityId, Slot)>,
    ) -> Vec<(ActivityId, Slot)> {
        slots.sort_by_key(|(id, _)| {
            let place = self.index.get(id).copied().unwrap_or(usize::MAX);
            (core::cmp::Reverse(self.activity(*id).map_or(0, |one| one.priority)), place)
        });
        slots
    }

    /// Its tickets are there: it starts, if all else is still right.
    pub(super) fn granted(&mut self, id: ActivityId) {
        let Some(asked) = self.asked.get(&id).copied() else { return };
        let planned = self.planned.get(&id).copied();
        let ready = planned.map(|slot| self.ready(id, slot, asked.early));
        let Some(Ok(slot)) = ready else { return self.withdraw(id) };
        self.asked.remove(&id);
        let early = planned.is_some_and(|planned| slot.start < planned.start);
        self.planned.remove(&id);
        let cutoff = self.activity(id).map_or(slot.end, |one| cutoff(one, slot, self.plan.end));
        self.state.running.push(Running {
            id,
            started: slot.start,
            ends: slot.end.min(cutoff),
            cutoff,
            paused: None,
            data: Bytes::ZERO,
        });
        self.changes_at_start(id);
        self.actions.push(Action::Start(Start { id, slot, early }));
        if early {
            self.wish(Why::StartedEarly(id));
        }
    }
}

/// Nothing runs after the plan's end.
fn cutoff(activity: &Activity, slot: Slot, end: Time) -> Time {
    activity.starts.get(slot.range).map_or(slot.end, |range| range.cutoff).min(end)
}
