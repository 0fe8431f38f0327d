//! When a new plan is wanted.

use super::ready::NotReady;
use super::{Action, Control};
use crate::state::Mode;
use crate::trace::Why;
use crate::units::{Span, Time};

impl Control {
    pub(super) fn wish(&mut self, why: Why) {
        self.wishes.insert(why);
    }

    /// What is wanted is said while the computer is up: nobody plans in sleep.
    pub(super) fn want_plans(&mut self) {
        self.notice_what_is_late();
        self.notice_what_runs_too_long();
        if self.now().since(self.planned_at) >= self.options.period {
            self.wish(Why::Periodic);
        }
        // A plan that took over is timed once, also by who does not plan again.
        if !self.options.replans && !self.is_untimed {
            return self.wishes.clear();
        }
        // Who has just come up plans with what it finds, and not with what it knew.
        let knows = !self.looks_around && self.blind.is_none();
        let can = self.state.mode == Mode::Awake && knows;
        if can && !self.wishes.is_empty() {
            let wishes: Vec<_> = std::mem::take(&mut self.wishes).into_iter().collect();
            self.planned_at = self.now();
            self.tries_again |= wishes.iter().any(|why| is_gap(*why));
            self.actions.push(Action::Replan(wishes));
        }
    }

    /// Once for each plan: a plan that does not help is not made again and again.
    fn wish_once(&mut self, why: Why) {
        if self.wished.insert(why) {
            self.wish(why);
        }
    }

    /// What cannot be helped is looked at again when a commit window has gone by.
    fn wish_now_and_then(&mut self, why: Why) {
        if self.now() >= self.looked_at_again() {
            self.wish(why);
        }
    }

    fn notice_what_is_late(&mut self) {
        let latest = self.now().before(self.parameters.handover_tolerance);
        let late: Vec<_> = self
            .planned
            .iter()
            .filter(|(_, slot)| slot.start < latest)
            .map(|(id, slot)| (*id, *slot))
            .collect();
        for (id, slot) in late {
            if let Err(NotReady::Zone(zone)) = self.ready(id, slot, false) {
                self.found_cold(zone);
            }
            self.wish_now_and_then(Why::Late(id));
        }
    }

    /// It is heated again from scratch.
    fn found_cold(&mut self, zone: String) {
        if self.state.cold.contains(&zone) {
            return;
        }
        if let Some(since) = self.state.heating.get_mut(&zone) {
            *since = self.state.now;
        }
        self.state.cold.push(zone);
        self.wish_once(Why::ZoneCold);
    }

    fn notice_what_runs_too_long(&mut self) {
        let now = self.now();
        let too_long: Vec<_> = self
            .state
            .running
            .iter()
            .filter(|running| running.paused.is_none() && now >= running.ends)
            .map(|running| running.id)
            .collect();
        for id in too_long {
            self.wish_now_and_then(Why::Overran(id));
        }
    }

    /// When what is late, or runs too long, is looked at again.
    pub(super) fn looked_at_again(&self) -> Time {
        let commit = self.parameters.commit.get().max(1_000);
        self.planned_at.after(Span::new(commit))
    }
}

/// Whether there is time now that was planned for something else.
const fn is_gap(why: Why) -> bool {
    matches!(why, Why::EndedEarly(_) | Why::Outcome(_) | Why::NotStarted(_))
}
