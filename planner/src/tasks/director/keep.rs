//! What has become of activities, for the state that plans are made from.

use faregate_scheduler::task::TaskId;

use super::Director;
use super::adopt::start_of;
use crate::plan::{ActivityId, Outcome};
use crate::state::{Ended, Running};
use crate::tasks::generated::Generated;
use crate::timed::Slot;
use crate::trace::Why;
use crate::units::{Bytes, Span};

impl Director {
    pub(super) fn runs(&mut self, id: TaskId) {
        let now = self.state.now;
        let Some(activity) = self.activity(id) else { return };
        let (zones, task) = (activity.zones.clone(), id);
        let id = activity.id;
        let planned = self.timed.slot(id).or_else(|| self.slot_of(task));
        let Some(slot) = planned else { return };
        let range = activity.starts.get(slot.range);
        let end = self.setting.plan.end;
        let cutoff = range.map_or(end, |range| range.cutoff.min(end));
        let ends = now.after(slot.length());
        let running = Running { id, started: now, ends, cutoff, paused: None, data: Bytes::ZERO };
        self.state.running.push(running);
        self.named.starts(&self.setting.plan, &mut self.state, id);
        for zone in zones {
            self.is_used(&zone);
        }
        if now > slot.start.after(self.setting.parameters.handover_tolerance) {
            self.wish(Why::Late(id));
        }
        if self.early.remove(&task).is_some() && now < slot.start {
            self.wish(Why::StartedEarly(id));
        }
    }

    /// When a task that the present plan has not got was to run.
    fn slot_of(&self, id: TaskId) -> Option<Slot> {
        let task = &self.live.get(&id)?.task;
        let start = start_of(self.setting.epoch, task);
        let length = i64::try_from(task.duration.as_micros() / 1_000).unwrap_or(i64::MAX);
        Some(Slot { start, end: start.after(Span::new(length)), range: 0 })
    }

    /// A zone in use keeps itself warm: heating for it is over, if it is not for
    /// something else.
    fn is_used(&mut self, zone: &str) {
        let is_heated = self.live.iter().any(|(id, live)| {
            live.started
                && matches!(self.numbers.what(*id), Some(Generated::Heating(of, _)) if of == zone)
        });
        if !is_heated {
            self.state.heating.remove(zone);
        }
    }

    pub(super) fn paused(&mut self, id: TaskId) {
        let now = self.state.now;
        let Some(running) = self.state.running.iter_mut().find(|one| one.id.get() == id.get())
        else {
            return;
        };
        running.paused = Some(now);
        let id = running.id;
        self.wish(Why::Tickets(id));
    }

    /// It goes on, and ends so much later.
    pub(super) fn resumed(&mut self, id: TaskId) {
        let now = self.state.now;
        let running = self.state.running.iter_mut().find(|one| one.id.get() == id.get());
        let Some(running) = running else { return };
        let Some(since) = running.paused.take() else { return };
        running.ends = running.ends.after(now.since(since));
        let id = running.id;
        self.wish(Why::Tickets(id));
    }

    /// What runs becomes what has ended.
    pub(super) fn ends(&mut self, id: TaskId, outcome: Outcome) {
        let modelled = self.activity(id).map_or(Bytes::ZERO, |one| one.data);
        let running = self.state.running.iter().position(|one| one.id.get() == id.get());
        let Some(place) = running else { return };
        let running = self.state.running.remove(place);
        let (id, started, ended) = (running.id, Some(running.started), self.state.now);
        // Until somebody says what it really was.
        let data = if outcome == Outcome::Succeeded { modelled } else { running.data };
        self.state.ended.push(Ended { id, outcome, started, ended, data });
        self.named.ends(&self.setting.plan, &mut self.state, id);
        if ended.after(self.setting.parameters.handover_tolerance) < running.ends {
            self.freed = true;
            self.wish(Why::EndedEarly(id));
        }
        if outcome != Outcome::Succeeded {
            self.freed = true;
            self.wish(Why::Outcome(id));
        }
    }

    /// It will not start.
    pub(super) fn gives_up(&mut self, id: ActivityId) {
        let (outcome, ended) = (Outcome::NotStarted, self.state.now);
        self.state.ended.push(Ended { id, outcome, started: None, ended, data: Bytes::ZERO });
        self.freed = true;
        self.wish(Why::NotStarted(id));
    }
}
