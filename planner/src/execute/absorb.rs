//! What happened, taken in.

use super::{Action, Control, Event, NextPlan, with_what_runs};
use crate::plan::{ActivityId, Kind, Outcome};
use crate::state::Mode;
use crate::timed::{Fate, TimedPlan};
use crate::trace::{Cause, Unstarted, Why};
use crate::units::Bytes;

impl Control {
    pub(super) fn absorb(&mut self, event: Event) {
        match event {
            Event::Tick => {}
            Event::Estimate { charge, zones } => {
                self.estimated(charge);
                self.state.cold.retain(|zone| !zones.get(zone).copied().unwrap_or(false));
                self.warm = zones;
            }
            Event::Variable(name, Some(value)) => {
                self.state.variables.insert(name, value);
            }
            Event::Variable(name, None) => {
                self.state.variables.remove(&name);
            }
            Event::Granted(id) => self.granted(id),
            Event::Taken(id) => self.taken(id),
            Event::Returned(id) => self.returned(id),
            Event::Ended(id, outcome, data) => self.end(id, outcome, Some(data)),
            Event::Data(id, data) => self.count(id, data),
            Event::Mode(mode) => self.mode_is(mode),
            Event::Windows(windows) => {
                self.state.queried(windows);
                self.wish(Why::Windows);
            }
            Event::Veto(id) => {
                // A manual block that has begun has started, though nobody starts it.
                let has_begun = self.block_now().is_some_and(|block| block.id == id);
                if self.is_open(id) && !has_begun {
                    self.give_up(id, Unstarted::Vetoed);
                }
            }
            Event::Stop(id) => {
                if self.running(id).is_some() {
                    self.abort(id, Cause::Ordered);
                }
            }
            Event::Adopt(timed) => self.adopt(*timed),
            Event::Next(answer) => self.answered(answer),
        }
    }

    /// What is planned from now on. What waits for its tickets goes on waiting,
    /// if it is still due.
    pub(super) fn adopt(&mut self, timed: TimedPlan) {
        self.planned.clear();
        for row in &timed.rows {
            let is_block = self
                .activity(row.id)
                .is_some_and(|activity| matches!(activity.kind, Kind::ManualShutdown { .. }));
            if let Fate::Scheduled(slot) = row.fate
                && self.is_open(row.id)
                && !is_block
            {
                self.planned.insert(row.id, slot);
            }
        }
        self.timed = timed;
        self.is_untimed = false;
        self.planned_at = self.now();
        self.wished.clear();
        self.freed |= std::mem::take(&mut self.tries_again);
        let given_up: Vec<_> = self.asked.keys().filter(|id| !self.is_due(**id)).copied().collect();
        for id in given_up {
            self.withdraw(id);
        }
    }

    pub(super) fn is_due(&self, id: ActivityId) -> bool {
        self.planned.get(&id).is_some_and(|slot| slot.start <= self.state.now)
    }

    pub(super) fn withdraw(&mut self, id: ActivityId) {
        if self.asked.remove(&id).is_some() {
            self.actions.push(Action::Withdraw(id));
        }
    }

    fn taken(&mut self, id: ActivityId) {
        let now = self.now();
        let pausable = self.activity(id).is_some_and(|activity| activity.pausable);
        let Some(running) = self.running_mut(id).filter(|running| running.paused.is_none()) else {
            return;
        };
        if pausable {
            running.paused = Some(now);
            self.actions.push(Action::Pause(id));
            self.wish(Why::Tickets(id));
        } else {
            self.abort(id, Cause::TicketsTaken);
        }
    }

    /// It goes on, and ends so much later.
    fn returned(&mut self, id: ActivityId) {
        let now = self.now();
        let Some(running) = self.running_mut(id) else { return };
        let Some(since) = running.paused.take() else { return };
        running.ends = running.ends.after(now.since(since));
        self.actions.push(Action::Resume(id));
        self.wish(Why::Tickets(id));
    }

    fn count(&mut self, id: ActivityId, data: Bytes) {
        if let Some(running) = self.running_mut(id) {
            running.data = data;
        } else if let Some(ended) = self.state.ended.iter_mut().find(|ended| ended.id == id) {
            ended.data = data;
        }
    }

    fn mode_is(&mut self, mode: Mode) {
        if self.state.mode != mode {
            self.state.mode = mode;
            self.state.mode_since = self.now();
        }
        // What the charge and the zones are is known again.
        if mode == Mode::Awake {
            self.looks_around = true;
            self.wish(Why::Periodic);
        }
    }

    /// The next plan takes over: what runs stays, what has not begun is dropped.
    fn answered(&mut self, answer: Result<std::sync::Arc<crate::Plan>, String>) {
        if self.next_plan != NextPlan::AskedFor {
            return;
        }
        self.next_plan = NextPlan::None;
        let merged =
            |next: std::sync::Arc<crate::Plan>| with_what_runs(&next, &self.plan, &self.state);
        match answer.and_then(merged) {
            Ok(plan) => self.hand_over_to(std::sync::Arc::new(plan)),
            Err(why) => self.actions.push(Action::NoNextPlan(why)),
        }
    }

    pub(super) fn abort(&mut self, id: ActivityId, cause: Cause) {
        self.end(id, Outcome::Aborted, None);
        self.actions.push(Action::Abort(id, cause));
    }
}
