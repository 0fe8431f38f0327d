//! Starts before the planned one: when something ended early, failed or did not
//! start, what is planned next may start at once.
//!
//! What is checked is what the control thread checks. The manager then starts
//! the task, if its tickets are there; if they are not for longer than a dispatch
//! may be late, it waits for its planned start again.

use std::collections::BTreeMap;

use faregate_scheduler::manager::Telecommand;
use faregate_scheduler::task::TaskId;

use super::Director;
use crate::execute::Look;
use crate::plan::{Activity, ActivityId, Kind};
use crate::state::{Running, State};
use crate::tasks::generated::Generated;
use crate::timed::{Fate, Slot};
use crate::trace::Why;
use crate::units::{Bytes, Time};

/// Whether there is time now that was planned for something else.
pub(super) const fn makes_room(why: Why) -> bool {
    matches!(why, Why::EndedEarly(_) | Why::Outcome(_) | Why::NotStarted(_))
}

impl Director {
    /// In the order of importance, whatever can start now without anything
    /// planned having to start later for it.
    pub(super) fn start_early(&mut self) {
        if !std::mem::take(&mut self.freed) || !self.starts_early {
            return;
        }
        let now = self.state.now;
        let mut planned = self.planned();
        let mut state = self.state.clone();
        // Who is due and waits for its tickets is expected to start now.
        let due: Vec<_> = planned.extract_if(.., |_, slot| slot.start <= now).collect();
        due.into_iter().for_each(|(id, slot)| begins(&mut state, id, slot));
        for id in self.by_importance() {
            let Some(slot) = planned.get(&id).copied() else { continue };
            let Some(from_now) = self.could_start(id, slot, &state, &planned) else { continue };
            planned.remove(&id);
            begins(&mut state, id, from_now);
            self.ask_early(id);
        }
    }

    /// What is planned and has not started.
    fn planned(&self) -> BTreeMap<ActivityId, Slot> {
        let rows = self.timed.rows.iter();
        let slots = rows.filter_map(|row| match row.fate {
            Fate::Scheduled(slot) => Some((row.id, slot)),
            _ => None,
        });
        slots.filter(|(id, _)| task(*id).is_some_and(|id| self.waits(id))).collect()
    }

    fn by_importance(&self) -> Vec<ActivityId> {
        let mut all: Vec<&Activity> = self.setting.plan.activities.iter().collect();
        all.sort_by_key(|one| core::cmp::Reverse(one.priority));
        all.into_iter().map(|one| one.id).collect()
    }

    /// In its planned range alone: its task has the cutoff of that one. Nor one
    /// whose cutoff is its planned end.
    fn could_start(
        &self,
        id: ActivityId,
        slot: Slot,
        state: &State,
        planned: &BTreeMap<ActivityId, Slot>,
    ) -> Option<Slot> {
        let live = self.live.get(&task(id)?)?;
        let activity = self.activity(live.task.id)?;
        if matches!(activity.kind, Kind::Expanding { .. }) && !live.task.mandatory {
            return None;
        }
        let waits = live.task.after.iter().any(|on| self.live.contains_key(&on.task));
        let (plan, parameters) = (&*self.setting.plan, &*self.setting.parameters);
        let (timed, warm) = (&self.timed, &|zone: &str| self.is_warm(zone));
        let look = Look { plan, parameters, state, timed, planned, warm, spent: self.spent };
        let ready = look.ready(id, slot, true).ok().filter(|_| !waits);
        ready.filter(|ready| ready.range == slot.range)
    }

    /// A zone is warm while it is used, and when it was heated for what comes.
    fn is_warm(&self, zone: &str) -> bool {
        let uses = |id| {
            let activities = self.setting.plan.activities.iter();
            activities.filter(|one| one.id == id).any(|one| one.zones.iter().any(|of| of == zone))
        };
        let now = self.state.now;
        let just = |ended: Time| ended.after(self.setting.parameters.handover_tolerance) >= now;
        let running = self.state.running.iter().any(|one| uses(one.id));
        let ended = self.state.ended.iter().any(|one| just(one.ended) && uses(one.id));
        let is_heated = self.state.heating.contains_key(zone) && !self.will_heat(zone);
        let is_cold = self.state.cold.iter().any(|one| one == zone);
        !is_cold && (running || ended || is_heated)
    }

    fn will_heat(&self, zone: &str) -> bool {
        let heats = |id: &TaskId| matches!(self.numbers.what(*id), Some(Generated::Heating(of, _)) if of == zone);
        self.live.keys().any(heats)
    }

    /// Its window opens now.
    fn ask_early(&mut self, id: ActivityId) {
        let now = self.state.now;
        let Some(id) = task(id) else { return };
        self.early.insert(id, now);
        self.open_at(id, now);
    }

    fn open_at(&mut self, id: TaskId, opens: Time) {
        let epoch = self.setting.epoch;
        let Some(live) = self.live.get_mut(&id) else { return };
        let Some(window) = live.task.windows.first_mut() else { return };
        window.opens = faregate_scheduler::task::When::At(epoch.wall(opens));
        self.orders.push(Telecommand::SetWindows(id, live.task.windows.clone()));
    }

    /// Who did not get its tickets in time waits for its planned start.
    pub(super) fn give_up_early_starts(&mut self) {
        let now = self.state.now;
        let is_late = |since: &Time| self.early_until(*since) <= now;
        let late: Vec<_> =
            self.early.iter().filter(|(_, since)| is_late(since)).map(|(id, _)| *id).collect();
        for id in late {
            self.early.remove(&id);
            let slot = self.activity(id).and_then(|one| self.timed.slot(one.id));
            if let Some(slot) = slot {
                self.open_at(id, slot.start);
            }
        }
    }

    /// Until when it is waited for that a task starts early: a millisecond at
    /// least, or nobody could.
    pub(super) fn early_until(&self, since: Time) -> Time {
        since
            .after(self.setting.parameters.handover_tolerance)
            .max(since.after(crate::units::Span::new(1)))
    }
}

/// Counts something as running from now on.
fn begins(state: &mut State, id: ActivityId, slot: Slot) {
    let now = state.now;
    let ends = now.after(slot.length());
    let running = Running { id, started: now, ends, cutoff: ends, paused: None, data: Bytes::ZERO };
    state.running.push(running);
}

const fn task(id: ActivityId) -> Option<TaskId> {
    TaskId::new(id.get())
}
