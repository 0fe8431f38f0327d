//! What the manager tells, taken in.

use std::collections::BTreeSet;

use faregate_scheduler::manager::Note;
use faregate_scheduler::task::{Outcome as TaskOutcome, TaskId};

use super::Director;
use crate::plan::Outcome;
use crate::state::Mode;
use crate::tasks::generated::Generated;
use crate::trace::Why;
use crate::units::Time;

impl Director {
    /// Something changed in the schedule.
    pub fn heard(&mut self, now: Time, note: &Note) {
        self.pass(now);
        match note {
            Note::Started(attempt) => self.started(attempt.occurrence.task),
            Note::Paused(attempt) => self.paused(attempt.occurrence.task),
            Note::Resumed(attempt) => self.resumed(attempt.occurrence.task),
            Note::Preempted(attempt) => self.lost(attempt.occurrence.task),
            Note::Ended { occurrence, outcome } => self.over(occurrence.task, *outcome),
            Note::Missed { task, .. } => self.over(*task, TaskOutcome::Missed),
            Note::NeverRuns { task, .. } => self.never_runs(*task),
            Note::Overran { attempt, .. } => {
                let id = attempt.occurrence.task;
                if let Some(activity) = self.activity(id) {
                    self.wish(Why::Overran(activity.id));
                }
            }
            Note::Removed(id) => {
                self.leaving.remove(id);
            }
            Note::Accepted(_)
            | Note::Waits { .. }
            | Note::Stopping { .. }
            | Note::Over { .. }
            | Note::Runaway(_)
            | Note::Mode { .. } => {}
        }
    }

    /// Also one that the manager was told to take out at that very moment: it
    /// ends it, and what has begun has begun.
    fn started(&mut self, id: TaskId) {
        self.live.extend(self.leaving.remove(&id).map(|live| (id, live)));
        let Some(live) = self.live.get_mut(&id) else { return };
        live.started = true;
        match self.numbers.what(id).cloned() {
            Some(what) => self.phase_began(what),
            None => self.runs(id),
        }
    }

    fn phase_began(&mut self, what: Generated) {
        match what {
            Generated::Wakeup(_) => self.computer(Mode::WakingUp),
            Generated::Awake(_) => self.computer(Mode::Awake),
            Generated::Shutdown(_) => self.computer(Mode::ShuttingDown),
            Generated::Heating(zone, _) => {
                let now = self.state.now;
                self.state.heating.entry(zone).or_insert(now);
            }
            Generated::Window(..) => {}
        }
    }

    /// The computer begins to do this; what has passed of it counts.
    fn computer(&mut self, mode: Mode) {
        if self.state.mode != mode {
            self.state.mode = mode;
            self.state.mode_since = self.state.now;
        }
    }

    /// The tickets of something that cannot be paused were taken.
    fn lost(&mut self, id: TaskId) {
        let Some(live) = self.live.get(&id) else { return };
        // The manager would run it again from the start, as long as it could
        // start.
        if live.closes >= self.state.now {
            let mut gone = BTreeSet::from([id]);
            self.with_dependants(&mut gone);
            self.remove(gone);
        }
        self.live.remove(&id);
        match self.numbers.what(id).cloned() {
            Some(what) => self.phase_lost(what),
            None => self.ends(id, Outcome::Aborted),
        }
    }

    fn phase_lost(&mut self, what: Generated) {
        match what {
            Generated::Heating(zone, _) => self.zone_is_cold(&zone),
            // It is up all the same: its draw is asked for again.
            Generated::Awake(_) | Generated::Wakeup(_) | Generated::Shutdown(_) => {
                self.wish(Why::Periodic);
            }
            Generated::Window(..) => {}
        }
    }

    /// A phase that did not get its draw in time. It is tried again when the
    /// commit window is over, and not as often as it is missed.
    fn phase_missed(&mut self, what: &Generated) {
        if !matches!(what, Generated::Window(..)) {
            self.tries_again();
        }
    }

    fn tries_again(&mut self) {
        let at = self.looked_at_again();
        self.again_at = Some(self.again_at.map_or(at, |other| other.min(at)));
    }

    fn over(&mut self, id: TaskId, outcome: TaskOutcome) {
        let Some(live) = self.live.remove(&id) else { return };
        self.held.remove(&id);
        self.early.remove(&id);
        self.ending.remove(&id);
        match self.numbers.what(id).cloned() {
            Some(what) if !live.started => self.phase_missed(&what),
            Some(what) => self.phase_over(what, outcome),
            None if live.started => self.ends(id, translated(outcome)),
            None => self.did_not_start(id),
        }
    }

    fn phase_over(&mut self, what: Generated, outcome: TaskOutcome) {
        if outcome != TaskOutcome::Succeeded {
            return self.phase_lost(what);
        }
        let takes_no_time = self.setting.parameters.shutdown.duration.get() == 0;
        match what {
            Generated::Heating(zone, _) => self.state.cold.retain(|one| *one != zone),
            Generated::Shutdown(_) => self.computer(Mode::Asleep),
            Generated::Awake(_) if takes_no_time => self.computer(Mode::Asleep),
            Generated::Awake(_) | Generated::Wakeup(_) | Generated::Window(..) => {}
        }
    }

    /// Its window is over. It may have another one.
    fn did_not_start(&mut self, id: TaskId) {
        let Some(activity) = self.activity(id) else { return };
        let (id, now) = (activity.id, self.state.now);
        let is_last = activity.starts.iter().all(|range| range.to <= now);
        if is_last {
            self.gives_up(id);
        }
        // The computer was up for it, and may be asleep by now.
        self.tries_again();
        self.wish(Why::NotStarted(id));
    }

    /// A prior ended otherwise, and a new plan may know better. What could not
    /// run even alone is given up.
    fn never_runs(&mut self, id: TaskId) {
        let Some(live) = self.live.remove(&id) else { return };
        self.held.remove(&id);
        self.early.remove(&id);
        match self.numbers.what(id).cloned() {
            Some(what) => self.phase_missed(&what),
            None if live.task.after.iter().all(|on| self.live.contains_key(&on.task)) => {
                if let Some(activity) = self.activity(id) {
                    self.gives_up(activity.id);
                }
            }
            None => {}
        }
    }
}

const fn translated(outcome: TaskOutcome) -> Outcome {
    match outcome {
        TaskOutcome::Succeeded => Outcome::Succeeded,
        TaskOutcome::Failed => Outcome::Failed,
        TaskOutcome::Aborted => Outcome::Aborted,
        TaskOutcome::Missed => Outcome::NotStarted,
    }
}
