//! Routine tasks keep their phase, whatever becomes of their occurrences.

use crate::manager::entry::{Entry, Place};
use crate::manager::occurrence::{CUTOFF, WINDOW};
use crate::manager::point::{Micros, Present};
use crate::manager::step::Step;
use crate::manager::timers::Kind;
use crate::manager::{Manager, Record};
use crate::time::Now;

/// A clock that is set back by less is as good as right.
const SET_BACK: Micros = 1_000_000;

pub(crate) const SUPERSEDED: &str = "superseded: still waiting when the next one was due";
pub(crate) const STILL_RUNNING: &str = "the one before was still running";
pub(crate) const PASSED: &str = "its time had passed";

impl Step<'_> {
    /// The occurrence after the present one is due. Of those that are due by
    /// now only the last can run: after a jump of the clock, or a long stop,
    /// the others are counted and not looked at.
    pub(crate) fn next_is_due(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        let Some(last) = entry.last_due_by(self.now).filter(|last| *last >= entry.next) else {
            let next = entry.due_of(entry.next);
            return self.set_timer(index, Kind::Next, Some(next));
        };
        if entry.has_started() {
            self.skip(index, last);
        } else {
            self.supersede(index, last);
        }
    }

    /// The present one goes on; those up to this one are lost.
    fn skip(&mut self, index: u32, last: u64) {
        let Some(entry) = self.entry_mut(index) else { return };
        let first = core::mem::replace(&mut entry.next, last.saturating_add(1));
        let next = entry.due_of(entry.next);
        self.set_timer(index, Kind::Next, Some(next));
        self.count_missed(index, first, last, STILL_RUNNING);
        self.settle_dependants(index, crate::task::Outcome::Missed, false);
    }

    /// The present one is lost, and those up to this one, which takes its place.
    fn supersede(&mut self, index: u32, last: u64) {
        let Some(entry) = self.entry(index) else { return };
        let first = entry.current;
        self.unseat(index);
        self.count_missed(index, first, last.saturating_sub(1), SUPERSEDED);
        self.settle_dependants(index, crate::task::Outcome::Missed, false);
        self.begin(index, last);
    }

    /// After the end of an occurrence: the next one, or the last that is due
    /// by now.
    pub(crate) fn follow(&mut self, index: u32) {
        // Whom it waits for may have gone while it did not wait.
        if let Some(why) = self.look_back(index) {
            return self.never_runs(index, why);
        }
        let Some(entry) = self.entry(index) else { return };
        let first = entry.next;
        let present = entry.last_due_by(self.now).unwrap_or(0).max(first);
        // Those that cannot start any more need not be looked at: seen from
        // here they are lost with those before them, however many they are.
        let number = entry.first_possible(present, self.now);
        if number > first {
            let closed = entry.window(present, self.now).is_none();
            let why = match number > present {
                true if closed => WINDOW,
                true => CUTOFF,
                false => PASSED,
            };
            self.count_missed(index, first, number.saturating_sub(1), why);
            self.settle_dependants(index, crate::task::Outcome::Missed, false);
        }
        self.begin(index, number);
    }
}

impl Step<'_> {
    /// Where the time of day was set back, times of day that have been come
    /// again, and so do occurrences, with new numbers: else a task would be idle
    /// until the clock is where it was.
    pub(crate) fn look_at_the_clock(&mut self) {
        if !self.manager.was_set_back(self.now) {
            return;
        }
        let all: Vec<u32> = self.manager.order.values().copied().collect();
        for index in all {
            self.bring_back(index);
        }
    }

    fn bring_back(&mut self, index: u32) {
        let now = self.now;
        let Some(entry) = self.entry_mut(index) else { return };
        if !entry.is_routine() || entry.cleans_up || entry.place == Place::Over {
            return;
        }
        let goes_on = entry.has_started();
        let first = if goes_on { entry.next } else { entry.current };
        let Some(back) = entry.back_for(first, now) else { return };
        entry.back = back;
        if goes_on {
            let next = entry.due_of(entry.next);
            return self.set_timer(index, Kind::Next, Some(next));
        }
        if self.disarm(index)
            && let Some(entry) = self.entry(index)
        {
            let occurrence = entry.occurrence();
            self.write(Record::Disarmed { occurrence });
        }
        self.unseat(index);
        self.begin(index, first);
    }
}

impl Manager {
    /// Whether the time of day was set back since the last step, by more than a
    /// clock is slowed down to be right. Then a step is due, whatever else is.
    #[must_use]
    pub(crate) fn was_set_back(&self, now: Present) -> bool {
        let ahead = |at: Present| at.wall.saturating_sub(at.elapsed);
        ahead(now) < ahead(self.last).saturating_sub(SET_BACK)
    }

    /// Whether the clock says that a step is to be taken now, though nothing
    /// happened and nothing is due.
    #[must_use]
    pub fn has_news_of_the_clock(&self, now: Now) -> bool {
        self.was_set_back(now.into())
    }
}

impl Entry {
    /// Whether an attempt of the present occurrence has begun.
    pub(crate) const fn has_started(&self) -> bool {
        self.attempts > 0
    }

    /// The first occurrence of a task that is accepted now: the next one, or
    /// the present one if its window is open.
    pub(crate) fn first_number(&self, now: crate::manager::point::Present) -> u64 {
        match self.last_due_by(now) {
            None => 0,
            Some(last) if self.window(last, now).is_some() => last,
            Some(last) => last.saturating_add(1),
        }
    }
}
