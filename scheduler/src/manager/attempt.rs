//! The life of an attempt: it starts, is stopped, goes on, and ends.

use crate::manager::entry::{Asked, Place, Stage, Then};
use crate::manager::limits::{GRACE, LATENESS};
use crate::manager::point::{Point, from_duration};
use crate::manager::step::Step;
use crate::manager::timers::Kind;
use crate::manager::{Action, Attempt, Exit, Note, Record, Stop, StopWhy};
use crate::task::{Outcome, Overrun, Preemption, Restart};

impl Step<'_> {
    /// The task whose present attempt this is.
    fn of_attempt(&self, attempt: Attempt) -> Option<u32> {
        let index = self.manager.named(attempt.occurrence)?;
        let entry = self.entry(index)?;
        (entry.attempts == attempt.number && entry.run.has_body()).then_some(index)
    }

    /// The body runs from now on: time of running counts, and so do its alarms.
    pub(crate) fn set_running(&mut self, index: u32) {
        let now = self.now.elapsed;
        let Some(entry) = self.entry_mut(index) else { return };
        entry.run.stage = Stage::Running;
        entry.run.since = now;
        entry.told = None;
        let (duration, overran) = (entry.task.duration, entry.run.overran);
        let left = from_duration(duration).saturating_sub(entry.run.ran);
        let silence = entry.task.heartbeat.map(from_duration);
        if !duration.is_zero() && !overran {
            let allowed = left.saturating_add(from_duration(LATENESS)).saturating_add(1);
            self.set_timer_in(index, Kind::Overrun, allowed);
        }
        if let Some(silence) = silence {
            self.set_timer_in(index, Kind::Silent, silence.saturating_add(1));
        }
        self.set_timer(index, Kind::Closed, None);
    }

    /// The body does not run any more.
    fn set_stage(&mut self, index: u32, stage: Stage) {
        let now = self.now.elapsed;
        let Some(entry) = self.entry_mut(index) else { return };
        if entry.run.stage == Stage::Running {
            let span = now.saturating_sub(entry.run.since);
            entry.run.ran = entry.run.ran.saturating_add(span);
        }
        entry.run.stage = stage;
        self.set_timer(index, Kind::Overrun, None);
        self.set_timer(index, Kind::Silent, None);
    }

    /// Stops the body as its policy says: its tickets were taken.
    pub(crate) fn pre_empt(&mut self, index: u32, by: String) {
        let Some(entry) = self.entry(index) else { return };
        if entry.run.stage != Stage::Running {
            return;
        }
        let how = match entry.task.preemption {
            Preemption::Pause => Stop::Pause,
            Preemption::Checkpoint { grace, signal } => Stop::Checkpoint { grace, signal },
            Preemption::Kill { grace } => Stop::Kill { grace },
            Preemption::Wait => Stop::Kill { grace: GRACE },
        };
        self.stop(index, how, Then::Again, StopWhy::Preempted { by });
    }

    /// Ends the body: the occurrence is over when it has exited.
    pub(crate) fn abort(&mut self, index: u32, why: &str) {
        self.kill(index, Then::Abort, why);
    }

    /// Ends the body: the attempt has failed.
    pub(crate) fn fail(&mut self, index: u32, why: &str) {
        self.kill(index, Then::Fail, why);
    }

    /// One that is being killed already only has its end mean something else.
    fn kill(&mut self, index: u32, means: Then, why: &str) {
        let Some(entry) = self.entry_mut(index) else { return };
        let grace = entry.grace();
        match &mut entry.run.stage {
            Stage::Idle => return,
            Stage::Stopping { how: Stop::Pause, then: Then::Again }
            | Stage::Running
            | Stage::Paused => {}
            Stage::Stopping { then, .. } | Stage::Runaway(then) => {
                // What has failed may be tried again, what is aborted may not.
                if *then == Then::Again || means == Then::Abort {
                    *then = means;
                }
                return;
            }
        }
        let why = StopWhy::Aborted { why: why.to_owned() };
        self.stop(index, Stop::Kill { grace }, means, why);
    }

    fn stop(&mut self, index: u32, how: Stop, then: Then, why: StopWhy) {
        self.set_stage(index, Stage::Stopping { how, then });
        let Some(entry) = self.entry(index) else { return };
        let attempt = entry.attempt();
        let text = match &why {
            StopWhy::Preempted { by } => by.clone(),
            StopWhy::Aborted { why } => why.clone(),
        };
        self.act(Action::Stop { attempt, how, why });
        self.note(Note::Stopping { attempt, why: text });
    }

    /// A body stands still.
    pub(crate) fn stopped(&mut self, attempt: Attempt) {
        let Some(index) = self.of_attempt(attempt) else { return };
        let paused = Stage::Stopping { how: Stop::Pause, then: Then::Again };
        if self.entry(index).is_none_or(|entry| entry.run.stage != paused) {
            return;
        }
        self.set_stage(index, Stage::Paused);
        self.write(Record::Paused { attempt, paused: true });
        self.note(Note::Paused(attempt));
    }

    /// A paused body goes on.
    pub(crate) fn go_on(&mut self, index: u32) {
        let Some(attempt) = self.entry(index).map(super::entry::Entry::attempt) else { return };
        self.write(Record::Paused { attempt, paused: false });
        self.act(Action::Continue { attempt });
        self.set_running(index);
        self.note(Note::Resumed(attempt));
    }

    /// The grace is over, and the function has not returned.
    pub(crate) fn ran_away(&mut self, attempt: Attempt) {
        let Some(index) = self.of_attempt(attempt) else { return };
        let Some(entry) = self.entry_mut(index) else { return };
        if let Stage::Stopping { then, .. } = &entry.run.stage {
            entry.run.stage = Stage::Runaway(then.clone());
            self.note(Note::Runaway(attempt));
        }
    }

    /// The body is over.
    pub(crate) fn exited(&mut self, attempt: Attempt, exit: Exit) {
        let Some(index) = self.of_attempt(attempt) else { return };
        let Some(entry) = self.entry(index) else { return };
        let by_itself = if exit == Exit::Code(0) { Outcome::Succeeded } else { Outcome::Failed };
        let outcome = match &entry.run.stage {
            Stage::Stopping { then: Then::Abort, .. } | Stage::Runaway(Then::Abort) => {
                Outcome::Aborted
            }
            Stage::Stopping { then: Then::Fail, .. } | Stage::Runaway(Then::Fail) => {
                Outcome::Failed
            }
            Stage::Stopping { how: Stop::Pause, .. } | Stage::Running | Stage::Paused => by_itself,
            Stage::Stopping { .. } | Stage::Runaway(_) => return self.again(index),
            Stage::Idle => return,
        };
        self.write(Record::Over { attempt, outcome: Some(outcome) });
        self.note(Note::Over { attempt, exit, outcome });
        self.set_stage(index, Stage::Idle);
        if outcome == Outcome::Failed && self.restarts(index) {
            return;
        }
        self.finish(index, outcome);
    }

    /// The attempt was pre-empted, and its body is gone: another one will be
    /// made. The request for its tickets stays at the agents.
    fn again(&mut self, index: u32) {
        let now = self.now;
        let Some(entry) = self.entry_mut(index) else { return };
        entry.saved =
            matches!(entry.run.stage, Stage::Stopping { how: Stop::Checkpoint { .. }, .. });
        self.set_stage(index, Stage::Idle);
        let Some(entry) = self.entry_mut(index) else { return };
        let attempt = entry.attempt();
        entry.run.ran = 0;
        entry.run.overran = false;
        let window = entry.present_window(now);
        self.write(Record::Over { attempt, outcome: None });
        self.note(Note::Preempted(attempt));
        let Some(window) = window else {
            self.unseat(index);
            return self.missed(index, super::occurrence::WINDOW);
        };
        if let Some(entry) = self.entry_mut(index) {
            entry.due = window.from;
        }
        let is_open = now.has_reached(window.from);
        let is_ready = self.entry(index).is_some_and(super::entry::Entry::is_ready);
        let is_asked = self.entry(index).is_some_and(|entry| entry.run.asked != Asked::No);
        if is_open && is_ready && is_asked {
            self.set_timer(index, Kind::Closed, window.until.map(|until| until.plus(1)));
        } else {
            self.unseat(index);
            self.seat(index, None);
        }
    }

    /// Whether the occurrence is tried again after a failure; if so it waits.
    pub(crate) fn restarts(&mut self, index: u32) -> bool {
        let now = self.now;
        let Some(entry) = self.entry_mut(index) else { return false };
        entry.failures = entry.failures.saturating_add(1);
        let Restart::OnFailure { limit, back_off } = entry.task.restart else { return false };
        if entry.failures > limit || entry.removed || self.manager.shutting_down {
            return false;
        }
        let earliest = now.elapsed.saturating_add(from_duration(back_off));
        self.unseat(index);
        self.seat(index, Some(Point::elapsed(earliest)));
        true
    }

    /// The attempt runs longer than its duration.
    pub(crate) fn overran(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index) else { return };
        if entry.place != Place::Live || entry.run.stage != Stage::Running {
            return;
        }
        entry.run.overran = true;
        let (attempt, duration, policy) =
            (entry.attempt(), entry.task.duration, entry.task.overrun);
        self.note(Note::Overran { attempt, duration });
        match policy {
            Overrun::Report => {}
            Overrun::Abort => self.abort(index, "it ran longer than its duration"),
            Overrun::AbortAndRestart => self.fail(index, "it ran longer than its duration"),
        }
    }

    /// The attempt has not said for too long that it is alive.
    pub(crate) fn silent(&mut self, index: u32) {
        self.fail(index, "it was silent for longer than its heartbeat");
    }

    /// The attempt says that it is alive.
    pub(crate) fn alive(&mut self, attempt: Attempt) {
        let Some(index) = self.of_attempt(attempt) else { return };
        let Some(entry) = self.entry(index) else { return };
        if entry.run.stage != Stage::Running {
            return;
        }
        if let Some(silence) = entry.task.heartbeat {
            self.set_timer_in(index, Kind::Silent, from_duration(silence).saturating_add(1));
        }
    }
}

impl super::entry::Entry {
    /// How long the body may take to end.
    pub(crate) fn grace(&self) -> crate::time::Duration {
        match self.task.preemption {
            Preemption::Checkpoint { grace, .. } | Preemption::Kill { grace } => grace,
            Preemption::Pause | Preemption::Wait => GRACE,
        }
    }
}
