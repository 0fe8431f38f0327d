//! What became of one task, from what the manager told of it.

use crate::analyze::MOST_RUNS;
use crate::analyze::phase::{self, Offset, base, first_number, from_load};
use crate::analyze::report::{Run, RunOutcome};
use crate::manager::{Attempt, WaitsFor};
use crate::task::{Outcome, Task};
use crate::time::{Duration, UnixTime};

/// A task and its history.
#[derive(Clone, Debug)]
pub(super) struct Track {
    pub(super) task: Task,
    /// It runs when another one failed, and has no times of its own.
    cleans_up: bool,
    /// When it was accepted, from the load of the schedule.
    accepted: Duration,
    /// The time of day at which it was accepted.
    wall: UnixTime,
    base: Offset,
    pub(super) first: u64,
    pub(super) runs: Vec<Run>,
    pub(super) waits: Vec<(Duration, Duration)>,
    pub(super) misses: Vec<Duration>,
    /// How many there were, shown or not.
    pub(super) missed: u64,
    pub(super) missed_because: Option<String>,
    pub(super) pauses: Duration,
    /// For what it waited, and for how long.
    pub(super) reasons: Vec<(String, Duration)>,
    waiting_for: Option<(String, Duration)>,
    /// Since when the present attempt stands still, or was to be run again.
    since: Option<Duration>,
    /// The occurrence that is over or lives.
    pub(super) seen: Option<u64>,
    pub(super) ended: bool,
    pub(super) never: Option<(Duration, String)>,
    /// The latest end by its cutoff, and the first.
    pub(super) cut: Option<Duration>,
    pub(super) overran: Option<Duration>,
}

impl Track {
    pub(super) fn new(task: Task, cleans_up: bool, accepted: Duration, wall: UnixTime) -> Self {
        Self {
            base: base(&task, wall),
            first: first_number(&task, wall),
            task,
            cleans_up,
            accepted,
            wall,
            runs: Vec::new(),
            waits: Vec::new(),
            misses: Vec::new(),
            missed: 0,
            missed_because: None,
            pauses: Duration::ZERO,
            reasons: Vec::new(),
            waiting_for: None,
            since: None,
            seen: None,
            ended: false,
            never: None,
            cut: None,
            overran: None,
        }
    }

    /// A task of this number was over, and another one has it now.
    pub(super) fn goes_on_as(&mut self, next: Self) {
        self.base = next.base;
        self.first = next.first;
        self.accepted = next.accepted;
        self.wall = next.wall;
        self.task = next.task;
        self.cleans_up = next.cleans_up;
        self.seen = None;
        self.ended = false;
        self.since = None;
    }

    pub(super) fn overran(&mut self, now: Duration) {
        self.overran.get_or_insert(now);
    }

    /// When this occurrence is due.
    pub(super) fn due(&self, occurrence: u64) -> Duration {
        self.shifted(self.base, occurrence)
    }

    fn shifted(&self, offset: Offset, occurrence: u64) -> Duration {
        let interval = self.task.interval.unwrap_or(Duration::ZERO);
        let shift = Offset::from(interval.saturating_mul(occurrence).as_micros());
        self.accepted.saturating_add(from_load(offset + shift))
    }

    /// The windows of this occurrence.
    pub(super) fn windows(
        &self,
        occurrence: u64,
    ) -> impl Iterator<Item = (Duration, Option<Duration>)> {
        self.task.windows.iter().map(move |window| {
            let place =
                |when| phase::offset(when, self.wall).map(|at| self.shifted(at, occurrence));
            (place(window.opens).unwrap_or_else(|| self.due(occurrence)), place(window.closes))
        })
    }

    /// When this occurrence must have ended; none: whenever.
    fn cutoff(&self, occurrence: u64) -> Option<Duration> {
        phase::offset(self.task.cutoff, self.wall).map(|at| self.shifted(at, occurrence))
    }

    pub(super) fn waits(&mut self, waits_for: &WaitsFor, now: Duration) {
        self.settle_reason(now);
        self.waiting_for = Some((format!("waited for {waits_for}"), now));
    }

    fn settle_reason(&mut self, now: Duration) {
        let Some((reason, since)) = self.waiting_for.take() else { return };
        let long = now.saturating_sub(since);
        match self.reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, sum)) => *sum = sum.saturating_add(long),
            None => self.reasons.push((reason, long)),
        }
    }

    pub(super) fn started(&mut self, attempt: Attempt, now: Duration) {
        self.settle_reason(now);
        let again = self.since.take();
        // Who cleans up is due when it starts, as far as anybody tells.
        let first = (!self.cleans_up).then(|| self.due(attempt.occurrence.number));
        if let Some(from) = again.or(first).filter(|from| *from < now) {
            self.waits.push((from, now));
        }
        self.seen = self.seen.max(Some(attempt.occurrence.number));
        self.ended = false;
        self.runs.push(Run {
            start: now,
            end: None,
            outcome: RunOutcome::Unfinished,
            segments: vec![(now, Duration::MAX)],
            occurrence: attempt.occurrence.number,
        });
    }

    pub(super) fn paused(&mut self, now: Duration) {
        self.close_segment(now);
        self.since = Some(now);
    }

    pub(super) fn resumed(&mut self, now: Duration) {
        self.settle_reason(now);
        self.end_pause(now);
        if let Some(run) = self.runs.last_mut() {
            run.segments.push((now, Duration::MAX));
        }
    }

    fn end_pause(&mut self, now: Duration) {
        if let Some(since) = self.since.take() {
            self.pauses = self.pauses.saturating_add(now.saturating_sub(since));
        }
    }

    fn close_segment(&mut self, now: Duration) {
        let last = self.runs.last_mut().and_then(|run| run.segments.last_mut());
        if let Some((_, until)) = last.filter(|(_, until)| *until == Duration::MAX) {
            *until = now;
        }
    }

    /// An attempt is over; none: it was pre-empted, and will be run again.
    pub(super) fn over(&mut self, outcome: Option<Outcome>, now: Duration) {
        self.settle_reason(now);
        self.end_pause(now);
        self.close_segment(now);
        let Some(run) = self.runs.last_mut() else { return };
        run.end = Some(now);
        run.outcome = match outcome {
            Some(Outcome::Succeeded) => RunOutcome::Succeeded,
            Some(Outcome::Failed) => RunOutcome::Failed,
            Some(Outcome::Aborted | Outcome::Missed) => RunOutcome::Aborted,
            None => RunOutcome::Preempted,
        };
        let occurrence = run.occurrence;
        if outcome == Some(Outcome::Aborted) && self.cutoff(occurrence) == Some(now) {
            self.cut = self.cut.or(Some(now));
        }
        // Until it is known that the occurrence is over, it may run again.
        self.since = Some(now);
    }

    pub(super) fn ended(&mut self) {
        self.since = None;
        self.ended = true;
    }

    /// Occurrences that were missed, which is told when the last of them is
    /// long over: each waited while its window was open and it was the present
    /// one.
    pub(super) fn missed(&mut self, first: u64, last: u64, why: &str, now: Duration) {
        self.settle_reason(now);
        self.missed_because.get_or_insert_with(|| why.to_owned());
        let again = self.since.filter(|_| self.seen == Some(first));
        let lost = last.saturating_sub(first).saturating_add(1);
        self.missed = self.missed.saturating_add(lost);
        for occurrence in (first..=last).take(MOST_RUNS) {
            // What was lost before its time is shown once.
            if occurrence > first && self.due(occurrence) > now {
                break;
            }
            let due = again.filter(|_| occurrence == first).unwrap_or(self.due(occurrence));
            let until = self.lost_at(occurrence, now).max(due);
            if due < until {
                self.waits.push((due, until));
            }
            self.misses.push(until);
        }
        if again.is_some() {
            self.since = None;
        }
        self.ended = true;
        self.seen = self.seen.max(Some(last));
    }

    /// When it was known that this occurrence will not run.
    fn lost_at(&self, occurrence: u64, now: Duration) -> Duration {
        let due = self.due(occurrence);
        let before = self.runs.partition_point(|run| run.start < due);
        let last = self.runs.get(before.wrapping_sub(1));
        if last.is_some_and(|run| run.end.is_none_or(|end| end > due)) {
            return due;
        }
        let closes = self.windows(occurrence).filter_map(|(_, closes)| closes).max();
        let next = self.task.interval.map(|_| self.due(occurrence.saturating_add(1)));
        closes.into_iter().chain(next).chain([now]).min().unwrap_or(now)
    }

    /// What was due and did not run at the horizon, and what still ran. Where
    /// more was to come (`cut`), what starts at the horizon is beyond it.
    pub(super) fn stop_at(&mut self, horizon: Duration, cut: bool) {
        self.settle_reason(horizon);
        if cut {
            self.runs.retain(|run| run.start < horizon);
            self.is_not_taken_at(horizon);
        }
        let paused = self.runs.last().is_some_and(|run| run.end.is_none());
        if let Some(since) = self.since.take() {
            let long = horizon.saturating_sub(since);
            if paused {
                self.pauses = self.pauses.saturating_add(long);
            } else if !long.is_zero() {
                self.waits.push((since, horizon));
            }
        } else if !paused && self.never.is_none() && !self.cleans_up {
            let routine = self.task.interval.is_some();
            let next = self.seen.map_or(self.first, |seen| seen.saturating_add(1));
            let due = self.due(next);
            if (routine || self.seen.is_none()) && due < horizon {
                self.waits.push((due, horizon));
            }
        }
        self.close_segment(horizon);
    }

    /// Who takes something at the horizon is beyond it.
    fn is_not_taken_at(&mut self, horizon: Duration) {
        let last = self
            .runs
            .last_mut()
            .filter(|run| run.outcome == RunOutcome::Preempted && run.end == Some(horizon));
        if let Some(run) = last {
            run.outcome = RunOutcome::Unfinished;
            run.end = None;
            self.since = None;
        }
    }
}
