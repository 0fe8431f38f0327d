//! The life of an occurrence: it becomes the present one, waits, and is over.

use crate::manager::entry::{Asked, Entry, Misses, Place, Run};
use crate::manager::limits::{LATENESS, MOST_ENDED};
use crate::manager::point::{Micros, Point, from_duration};
use crate::manager::step::Step;
use crate::manager::timers::Kind;
use crate::manager::{Action, Gap, Note, Record};
use crate::task::Outcome;

pub(crate) const WINDOW: &str = "its window closed";
pub(crate) const CUTOFF: &str = "its cutoff came before it could start";

impl Step<'_> {
    /// The occurrence of this number becomes the present one, and waits.
    pub(crate) fn begin(&mut self, index: u32, number: u64) {
        self.make_present(index, number);
        self.seat(index, None);
    }

    /// The occurrence of this number becomes the present one.
    pub(crate) fn make_present(&mut self, index: u32, number: u64) {
        self.disarm(index);
        let Some(entry) = self.entry_mut(index) else { return };
        entry.current = number;
        entry.next = number.saturating_add(1);
        entry.attempts = 0;
        entry.failures = 0;
        entry.saved = false;
        entry.told = None;
        entry.run = Run::new();
        entry.place = Place::Away;
        let due = entry.due_of(number);
        entry.arrival = entry.accepted.on_elapsed(due);
        let next = entry.is_routine().then(|| entry.due_of(entry.next));
        let cutoff = entry.cutoff_of(number);
        self.set_timer(index, Kind::Next, next);
        self.set_timer(index, Kind::Cutoff, cutoff);
    }

    /// The present occurrence, which has no body, waits for its time or for
    /// what it needs; not before `earliest`.
    pub(crate) fn seat(&mut self, index: u32, earliest: Option<Point>) {
        let (now, last) = (self.now, self.manager.last);
        let Some(entry) = self.entry_mut(index) else { return };
        let window = entry.present_window(now);
        let Some(window) = window.or_else(|| entry.late_window(entry.current, last, now)) else {
            return self.missed(index, WINDOW);
        };
        entry.place = Place::Away;
        entry.run = Run::new();
        let latest = earliest.into_iter().chain([window.from]).max_by_key(|at| now.until(*at));
        entry.due = latest.unwrap_or(window.from);
        let closed = window.until.map(|until| until.plus(1));
        if entry.is_ready() {
            self.enter(index);
        }
        self.set_timer(index, Kind::Closed, closed);
    }

    /// Into its class: nothing but time and what it needs keeps it from running.
    pub(crate) fn enter(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index) else { return };
        entry.place = Place::Class;
        let (class, due, rank) = (entry.class, entry.due, entry.rank());
        self.manager.classes.insert(class, due, rank, index);
    }

    /// Out of wherever it is kept; its tickets are given back.
    pub(crate) fn unseat(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        let (place, class, due, rank) = (entry.place, entry.class, entry.due, entry.rank());
        match place {
            Place::Class => self.manager.classes.remove(class, due, rank, index),
            Place::Live => {
                self.give_back(index);
                self.manager.live.retain(|other| *other != index);
            }
            Place::Away | Place::Over => return,
        }
        if let Some(entry) = self.entry_mut(index) {
            entry.place = Place::Away;
        }
    }

    /// Relinquishes the request or the tickets, if there are any.
    pub(crate) fn give_back(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index) else { return };
        let occurrence = entry.occurrence();
        if core::mem::replace(&mut entry.run.asked, Asked::No) != Asked::No {
            self.act(Action::Relinquish { occurrence });
        }
    }

    /// Out of its class, to be asked for at the agents.
    pub(crate) fn enlist(&mut self, index: u32) {
        self.unseat(index);
        if let Some(entry) = self.entry_mut(index) {
            entry.place = Place::Live;
            entry.run = Run::new();
            self.manager.live.push(index);
        }
    }

    /// The window of the present occurrence has closed. One that the manager
    /// was woken too late for has its chance; of several windows the next one
    /// counts.
    pub(crate) fn closed(&mut self, index: u32) {
        let Some(entry) = self.entry(index).filter(|entry| !entry.run.has_body()) else { return };
        if entry.late_window(entry.current, self.manager.last, self.now).is_some() {
            return self.set_timer_in(index, Kind::Closed, from_duration(LATENESS));
        }
        let has_another = entry.present_window(self.now).is_some();
        let not_before = entry.has_started().then_some(entry.due);
        self.unseat(index);
        if has_another {
            self.seat(index, not_before);
        } else {
            self.missed(index, WINDOW);
        }
    }

    /// The latest end of the present occurrence has come.
    pub(crate) fn cut_off(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        if entry.run.has_body() {
            return self.abort(index, "its cutoff");
        }
        if entry.attempts > 0 {
            return self.finish(index, Outcome::Aborted);
        }
        self.unseat(index);
        self.missed(index, CUTOFF);
    }

    /// The present occurrence, which is kept nowhere, is lost.
    pub(crate) fn missed(&mut self, index: u32, why: &'static str) {
        let Some(entry) = self.entry(index) else { return };
        let number = entry.current;
        self.count_missed(index, number, number, why);
        self.conclude(index, Outcome::Missed);
    }

    /// Counts occurrences that never ran; all of them are told of at once when
    /// something else happens to the task.
    pub(crate) fn count_missed(&mut self, index: u32, first: u64, last: u64, why: &'static str) {
        let count = last.saturating_sub(first).saturating_add(1);
        let goes_on = self
            .entry(index)
            .and_then(|entry| entry.misses.as_ref())
            .is_some_and(|misses| misses.why == why && misses.last.saturating_add(1) == first);
        if !goes_on {
            self.tell_missed(index);
        }
        let Some(entry) = self.entry_mut(index) else { return };
        let misses = entry.misses.get_or_insert(Misses { first, last, count: 0, why });
        misses.last = last;
        misses.count = misses.count.saturating_add(count);
        let mut occurrence = entry.occurrence();
        occurrence.number = last;
        let wall = self.wall();
        self.write(Record::Ended { occurrence, outcome: Outcome::Missed, wall });
    }

    /// Tells of a run of misses, which is over.
    pub(crate) fn tell_missed(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index) else { return };
        let task = entry.task.id;
        if let Some(Misses { first, last, count, why }) = entry.misses.take() {
            self.note(Note::Missed { task, first, last, count, why: why.to_owned() });
        }
    }

    /// The present occurrence is over: it ran.
    pub(crate) fn finish(&mut self, index: u32, outcome: Outcome) {
        let Some(entry) = self.entry(index) else { return };
        let (occurrence, has_run) = (entry.occurrence(), entry.has_started());
        let wall = self.wall();
        self.write(Record::Ended { occurrence, outcome, wall });
        self.note(Note::Ended { occurrence, outcome });
        self.unseat(index);
        if has_run {
            self.keep_gap(index, 0);
        }
        if matches!(outcome, Outcome::Failed | Outcome::Aborted) {
            self.clean_up(index);
        }
        self.conclude(index, outcome);
    }

    /// Its body ended so long ago: from then on it keeps its categories for a
    /// while.
    pub(crate) fn keep_gap(&mut self, index: u32, ago: Micros) {
        let Some(entry) = self.entry(index) else { return };
        let (gap, categories, task) = (entry.task.gap, entry.task.categories.mask(), entry.task.id);
        let left = from_duration(gap).saturating_sub(ago);
        if left > 0 && categories != 0 {
            let until = self.now.elapsed.saturating_add(left);
            self.manager.gaps.push(Gap { until, categories, task });
        }
    }

    /// What comes after the present occurrence.
    fn conclude(&mut self, index: u32, outcome: Outcome) {
        let Some(entry) = self.entry_mut(index) else { return };
        entry.last = Some(outcome);
        entry.place = Place::Away;
        entry.run = Run::new();
        for kind in [Kind::Closed, Kind::Cutoff, Kind::Overrun, Kind::Silent] {
            self.set_timer(index, kind, None);
        }
        let Some(entry) = self.entry(index) else { return };
        let (routine, cleans_up, id) = (entry.is_routine(), entry.cleans_up, entry.task.id);
        if entry.removed {
            self.settle_dependants(index, outcome, true);
            self.note(Note::Removed(id));
            return self.take_out(index);
        }
        if routine {
            self.settle_dependants(index, outcome, false);
            self.follow(index);
        } else if cleans_up {
            self.settle_dependants(index, outcome, false);
            self.rest(index);
        } else {
            self.over(index);
            self.settle_dependants(index, outcome, true);
        }
    }

    /// No occurrence will come.
    pub(crate) fn over(&mut self, index: u32) {
        self.tell_missed(index);
        self.is_over(index);
        self.forget_the_first();
    }

    pub(crate) fn is_over(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index) else { return };
        entry.place = Place::Over;
        if !core::mem::replace(&mut entry.cleans_up, false) {
            self.manager.open = self.manager.open.saturating_sub(1);
        }
        self.manager.ended.push_back(index);
        self.needs_no_cleanup(index);
    }

    /// Tasks that are over make room for those that ended later. Nobody misses
    /// them: who depends on one has heard of its end.
    pub(crate) fn forget_the_first(&mut self) {
        while self.manager.ended.len() > MOST_ENDED
            && let Some(index) = self.manager.ended.pop_front()
        {
            self.take_out(index);
        }
    }
}

impl Entry {
    /// Whether nothing but time and what it needs keeps it from running. An
    /// occurrence depends on others only until its first start.
    pub(crate) fn is_ready(&self) -> bool {
        let depends = || self.satisfied.iter().any(|satisfied| !satisfied);
        !self.held && (self.has_started() || !depends())
    }
}
