//! The manager: events in, actions out.
//!
//! It has no clock, thread, file or random number. Everything that happens at
//! one instant is one call of [`Manager::step`], which takes one decision.

mod action;
mod event;
mod needs;
mod note;
mod record;
mod restored;
mod words;

pub use action::{Action, Stop, StopWhy};
pub use event::{Addition, Event, Exit, Reading, Reply, Telecommand, TelecommandId};
pub use needs::Needs;
pub use note::{HeldBy, Note, WaitsFor};
pub use record::{Attempt, Occurrence, Record};
pub use restored::{Restored, RestoredTask};

use crate::mission::Mission;
use crate::task::{Task, TaskId};
use crate::time::{Due, Now};

/// Decides which tasks run, and remembers what became of them.
#[derive(Clone, Debug)]
pub struct Manager {
    mission: Mission,
}

/// What somebody who asks is told of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskStatus {
    /// Which occurrence: the one that lives, or the next.
    pub occurrence: Occurrence,
    /// Where it stands.
    pub state: State,
}

/// Where an occurrence stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Its time has not come: it is due at this instant.
    Pending(Due),
    /// It is due, and waits.
    Waiting(WaitsFor),
    /// An attempt runs.
    Running(Attempt),
    /// An attempt is being stopped.
    Stopping(Attempt),
    /// An attempt stands still.
    Paused(Attempt, WaitsFor),
    /// It is over, and was the last one.
    Ended(crate::task::Outcome),
}

impl Manager {
    /// A manager without tasks.
    #[must_use]
    pub fn new(mission: Mission) -> Self {
        Self { mission }
    }

    /// Goes on where a journal ends. What was interrupted counts as failed:
    /// the actions say so, and the executive carries them out before any
    /// event.
    #[must_use]
    pub fn restore(
        mission: Mission,
        restored: Restored,
        now: Now,
        actions: &mut Vec<Action>,
    ) -> Self {
        let _ = (restored, now, actions);
        Self { mission }
    }

    /// Applies everything that happened at this instant, in the order: exits,
    /// what becomes due, tickets and telecommands. Then takes one decision.
    pub fn step(&mut self, now: Now, events: Vec<Event>, actions: &mut Vec<Action>) {
        let _ = (now, events, actions, &self.mission);
    }

    /// When to call again, if nothing happens before.
    #[must_use]
    pub fn next_due(&self) -> Due {
        Due::default()
    }

    /// The task, if it is in the schedule.
    #[must_use]
    pub fn task(&self, id: TaskId) -> Option<&Task> {
        let _ = id;
        None
    }

    /// What the tickets of an occurrence that lives are for.
    #[must_use]
    pub fn needs(&self, occurrence: Occurrence) -> Option<Needs> {
        let _ = occurrence;
        None
    }

    /// Every task of the schedule, in its order.
    pub fn status(&self) -> impl Iterator<Item = TaskStatus> {
        core::iter::empty()
    }

    /// What the occurrence waits for, if it waits.
    #[must_use]
    pub fn waits_for(&self, occurrence: Occurrence) -> Option<WaitsFor> {
        let _ = occurrence;
        None
    }

    /// Whether no task lives or will become due: a schedule without routine
    /// tasks is over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        true
    }
}
