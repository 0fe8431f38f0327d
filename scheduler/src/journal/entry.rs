//! What stands in a journal's files: records, and what the journal says of
//! itself.

use serde::{Deserialize, Serialize};

use crate::journal::storage::Boot;
use crate::manager::{Attempt, Occurrence, Record, RestoredTask};
use crate::task::{Outcome, Task};
use crate::time::UnixTime;

/// One entry. Their order is part of the format: see
/// [`VERSION`](crate::journal::segment::VERSION).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Entry<R = Record> {
    /// The journal was opened, in this start of the host.
    Opened(Boot),
    /// It was closed in order: nothing was lost.
    Closed,
    /// The manager's own. (A writer has only a reference to it.)
    Record(R),
    /// The log before this one is so many bytes long.
    Continues(u64),
    /// A snapshot begins.
    Base(Base),
    /// A task of a snapshot.
    Kept(Box<Kept>),
    /// A snapshot is complete, with so many tasks.
    Complete(u64),
}

/// What a journal knows beside its tasks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Base {
    pub(super) modes: Vec<String>,
    pub(super) next_position: u64,
    /// In which start of the host the journal was opened last.
    pub(super) boot: Boot,
    /// Whether it was closed since.
    pub(super) closed: bool,
}

/// What a journal knows of a task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Kept {
    pub(super) task: Task,
    pub(super) load: u32,
    pub(super) position: u64,
    pub(super) accepted: UnixTime,
    pub(super) held: bool,
    pub(super) removed: bool,
    pub(super) ended: Option<(u64, Outcome)>,
    /// Attempts that began, of the occurrence of this number: one after it may
    /// have been missed while it waits for its next attempt.
    pub(super) attempts: (u64, u32),
    pub(super) running: Option<Attempt>,
    pub(super) armed: Option<Occurrence>,
    /// Power was lost while it was armed.
    pub(super) armed_in_vain: bool,
    /// A task that it cleans up after has failed, and it has not begun since.
    pub(super) has_to_clean: bool,
    /// Which of its dependencies were satisfied since it began last, in the
    /// task's order.
    pub(super) satisfied: Vec<bool>,
    /// It leaves the schedule when the attempt that began has ended.
    pub(super) leaving: bool,
    /// It runs when another one failed, and never by itself.
    pub(super) cleans_up: bool,
    /// When the last occurrence that ran was over.
    pub(super) ran_until: Option<UnixTime>,
}

impl Kept {
    /// An occurrence is over. It may have been missed while one before it still
    /// ran: then that one is not over.
    pub(super) fn end(&mut self, number: u64, outcome: Outcome) {
        self.running = self.running.filter(|attempt| attempt.occurrence.number != number);
        if self.attempts.0 == number {
            self.attempts.1 = 0;
        }
        if self.ended.is_some_and(|(ended, _)| ended >= number) {
            return;
        }
        self.ended = Some((number, outcome));
        self.armed = self.armed.filter(|armed| armed.number > number);
        self.armed_in_vain &= self.armed.is_some();
    }

    /// An attempt began. Answers whether nobody knew.
    pub(super) fn began(&mut self, attempt: Attempt) -> bool {
        let (number, before) = self.attempts;
        let before = if number == attempt.occurrence.number { before } else { 0 };
        self.attempts = (attempt.occurrence.number, before.max(attempt.number));
        before < attempt.number
    }

    /// The first attempt of an occurrence uses what others' outcomes satisfied.
    pub(super) fn use_dependencies(&mut self, attempt: Attempt) {
        if attempt.number == 1 {
            self.satisfied.fill(false);
        }
    }

    /// As a manager is told of it. One that cleans up is not over when it ran.
    pub(super) fn restored(self) -> RestoredTask {
        let ran_once = self.task.interval.is_none() && self.ended.is_some() && !self.cleans_up;
        RestoredTask {
            task: self.task,
            load: self.load,
            position: self.position,
            accepted: self.accepted,
            held: self.held,
            over: self.removed || ran_once,
            ended: self.ended,
            attempts: self.attempts,
            interrupted: self.running,
            may_have_started: self.armed_in_vain && self.running.is_none(),
            has_to_clean: self.has_to_clean,
            satisfied: self.satisfied,
            leaving: self.leaving,
            cleans_up: self.cleans_up,
            ran_until: self.ran_until,
        }
    }
}
