//! Going on where a journal ends.

use crate::manager::admit::Admission;
use crate::manager::point::Present;
use crate::manager::step::Step;
use crate::manager::{Attempt, Exit, Note, Record, Restored, RestoredTask};
use crate::task::{Outcome, Preemption, Restart};

/// What the journal says of a task, beside the task.
#[derive(Clone, Copy, Debug)]
struct Past {
    over: bool,
    ended: Option<(u64, Outcome)>,
    attempts: (u64, u32),
    interrupted: Option<Attempt>,
    may_have_started: bool,
    has_to_clean: bool,
    cleans_up: bool,
}

impl Step<'_> {
    /// Puts every task back where it was, and takes a first decision.
    pub(crate) fn restore(&mut self, restored: Restored) {
        self.manager.last = self.now;
        self.manager.classes.advance(self.now);
        self.manager.next_position = restored.next_position;
        for mode in restored.modes {
            // One that the mission does not have any more is not in force.
            let _ = self.enter_mode(&mode);
        }
        let tasks: Vec<_> = restored.tasks.into_iter().map(|task| self.put_back(task)).collect();
        for (index, past) in &tasks {
            if past.cleans_up && !past.over {
                self.make_clean_up(*index);
            }
            self.depend(*index);
        }
        for (index, past) in &tasks {
            self.go_on_from(*index, *past);
            self.may_retire(*index);
        }
        self.forget_the_first();
        self.decide();
    }

    fn put_back(&mut self, restored: RestoredTask) -> (u32, Past) {
        let RestoredTask { task, load, position, accepted, held, over, ended, satisfied, .. } =
            restored;
        let past = Past {
            over,
            ended,
            attempts: restored.attempts,
            interrupted: restored.interrupted,
            may_have_started: restored.may_have_started,
            has_to_clean: restored.has_to_clean,
            cleans_up: restored.cleans_up,
        };
        let wall = accepted.as_micros();
        let ago = self.now.wall.saturating_sub(wall);
        let accepted = Present { elapsed: self.now.elapsed.saturating_sub(ago), wall };
        let index = self.insert(task, Admission { load, position, accepted, held });
        if let Some(entry) = self.entry_mut(index) {
            entry.last = ended.map(|(_, outcome)| outcome);
            entry.removed = restored.leaving;
            if entry.satisfied.len() == satisfied.len() {
                entry.satisfied = satisfied;
            }
        }
        if over {
            self.is_over(index);
        }
        if let Some(ran_until) = restored.ran_until {
            // Where the clock was set back, all of the gap is to come.
            let ago = self.now.wall.saturating_sub(ran_until.as_micros()).max(0);
            self.keep_gap(index, ago);
        }
        (index, past)
    }

    fn go_on_from(&mut self, index: u32, past: Past) {
        let Some(entry) = self.entry(index) else { return };
        if past.over {
            return;
        }
        if let Some(why) = self.manager.can_never_run(entry) {
            return self.never_runs(index, why);
        }
        let (id, leaves) = (entry.task.id, entry.removed);
        let first = entry.first_number(entry.accepted);
        let number = past.ended.map_or(first, |(last, _)| last.saturating_add(1));
        self.is_back(index, number);
        let never = self.look_back(index);
        if past.interrupted.is_some() || past.may_have_started || past.attempts.1 > 0 {
            // It depended on others until it began.
            self.go_on_with(index, number, past);
        } else if leaves {
            self.note(Note::Removed(id));
            self.take_out(index);
        } else if let Some(why) = never {
            self.never_runs(index, why);
        } else if self.entry(index).is_some_and(|entry| entry.cleans_up) {
            self.clean_from(index, number, past.has_to_clean);
        } else {
            self.follow_from(index, number);
        }
    }

    /// An occurrence of which attempts began. One that may have begun and is
    /// not known to have ended has failed.
    fn go_on_with(&mut self, index: u32, number: u64, past: Past) {
        let next = number;
        let (of, attempts) = past.attempts;
        let number = if attempts > 0 { of } else { number };
        let number = past.interrupted.map_or(number, |attempt| attempt.occurrence.number);
        self.make_present(index, number);
        let interrupted = past.interrupted.is_some() || past.may_have_started;
        if attempts == 0 && past.interrupted.is_none() {
            // It may have begun, and used them.
            self.spend_dependencies(index);
        }
        let Some(entry) = self.entry_mut(index) else { return };
        // What was missed while it ran is not told again.
        entry.next = entry.next.max(next);
        entry.attempts = match past.interrupted {
            Some(attempt) => attempt.number,
            None => attempts.saturating_add(u32::from(past.may_have_started)),
        };
        let attempt = entry.attempt();
        // How many of them failed is not known: none may be tried too often.
        entry.failures = entry.attempts.saturating_sub(u32::from(interrupted));
        if !interrupted {
            // It was pre-empted, or has failed and is tried again. Where that
            // is not done it was pre-empted, by its policy.
            entry.saved = entry.task.restart == Restart::Never
                && matches!(entry.task.preemption, Preemption::Checkpoint { .. });
            return self.seat(index, None);
        }
        let outcome = Outcome::Failed;
        let exit = Exit::Failed("interrupted: the manager ended".into());
        self.write(Record::Over { attempt, outcome: Some(outcome) });
        self.note(Note::Over { attempt, exit, outcome });
        if !self.restarts(index) {
            self.finish(index, outcome);
        }
    }

    /// Where the time of day has been later than it is now.
    fn is_back(&mut self, index: u32, number: u64) {
        let now = self.now;
        if let Some(entry) = self.entry_mut(index)
            && let Some(back) = entry.back_for(number, now).filter(|_| number > 0)
        {
            entry.back = back;
        }
    }

    fn rest_at(&mut self, index: u32, number: u64) {
        if let Some(entry) = self.entry_mut(index) {
            entry.current = number;
            entry.next = number;
        }
    }

    /// Nothing is cleaned up at present. It may have to be: since before, or
    /// since one that was interrupted has failed just now.
    fn clean_from(&mut self, index: u32, number: u64, has_to: bool) {
        let waits = self.entry(index).is_some_and(|entry| !entry.is_resting());
        if waits {
            return;
        }
        self.rest_at(index, number);
        if has_to {
            self.begin_cleaning(index);
        }
    }

    /// No attempt began: what was due while nobody was there is lost, but for
    /// the last one, if its window is still open.
    fn follow_from(&mut self, index: u32, number: u64) {
        if let Some(entry) = self.entry_mut(index) {
            entry.next = number;
        }
        if self.entry(index).is_some_and(super::entry::Entry::is_routine) {
            self.follow(index);
        } else {
            self.begin(index, number);
        }
    }
}
