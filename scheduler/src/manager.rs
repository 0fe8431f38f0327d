//! The manager: events in, actions out.
//!
//! It has no clock, thread, file or random number. Everything that happens at
//! one instant is one call of [`Manager::step`], which takes one decision.

mod action;
mod admit;
mod arm;
mod attempt;
mod build_in;
mod classes;
mod cleanup;
mod decide;
mod defects;
mod demand;
mod depend;
mod entry;
mod event;
mod hand_over;
mod ledger;
pub mod limits;
mod mode;
mod needs;
mod note;
mod occurrence;
mod point;
mod rank;
mod reading;
mod record;
mod restore;
mod restored;
mod routine;
mod slab;
mod status;
mod step;
mod telecommand;
mod tickets;
mod timers;
mod times;
mod tree;
mod untold;
mod walk;
mod words;

pub use action::{Action, Stop, StopWhy};
pub use event::{Addition, Event, Exit, Reading, Reply, Telecommand, TelecommandId};
pub use needs::Needs;
pub use note::{HeldBy, Note, WaitsFor};
pub use record::{Attempt, Occurrence, Record};
pub use restored::{Restored, RestoredTask};

use std::collections::{BTreeMap, VecDeque};

use crate::manager::classes::Classes;
use crate::manager::entry::Entry;
use crate::manager::ledger::{Installed, Ledger};
use crate::manager::mode::Modes;
use crate::manager::point::{Micros, Present};
use crate::manager::reading::Measured;
use crate::manager::slab::Slab;
use crate::manager::step::Step;
use crate::manager::timers::Timers;
use crate::mission::Mission;
use crate::task::{Outcome, TaskId};
use crate::time::{Due, Now};

/// Decides which tasks run, and remembers what became of them.
#[derive(Clone, Debug)]
pub struct Manager {
    mission: Mission,
    installed: Installed,
    entries: Slab<Entry>,
    by_id: BTreeMap<TaskId, u32>,
    /// The schedule's order: by position.
    order: BTreeMap<u64, u32>,
    next_position: u64,
    /// How many tasks there were of each id that was used before.
    loads: BTreeMap<TaskId, u32>,
    /// These ids and numbers, in the order in which their tasks left.
    gone: VecDeque<(TaskId, u32)>,
    /// Who waits for an outcome of this task, and which of its dependencies
    /// that is.
    dependants: BTreeMap<TaskId, Vec<(u32, usize)>>,
    /// How many tasks that are not over name each one as their cleanup.
    needed: BTreeMap<TaskId, usize>,
    /// Tasks that clean up, and may have nobody left to do it for: index,
    /// position.
    idle: VecDeque<(u32, u64)>,
    classes: Classes,
    timers: Timers,
    /// Who was asked for at the agents, or has a body.
    live: Vec<u32>,
    gaps: Vec<Gap>,
    modes: Modes,
    measured: Measured,
    /// Tasks that can never run, and are to be taken out: index, position, why.
    doomed: VecDeque<(u32, u64, String)>,
    /// Tasks that are over, in the order in which they ended.
    ended: VecDeque<u32>,
    armed: Vec<u32>,
    /// The instants that were prepared for, by each clock.
    armed_for: [Option<Micros>; 2],
    /// Tasks that are not over; those that only clean up are not among them.
    open: usize,
    shutting_down: bool,
    /// How many occurrences were looked at.
    looks: u64,
    /// When the last step was.
    last: Present,
}

/// Categories that an ended task keeps for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Gap {
    until: Micros,
    categories: u128,
    task: TaskId,
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
    Ended(Outcome),
}

impl Manager {
    /// A manager without tasks.
    #[must_use]
    pub fn new(mission: Mission) -> Self {
        Self {
            installed: Installed::of(&mission),
            mission,
            entries: Slab::default(),
            by_id: BTreeMap::new(),
            order: BTreeMap::new(),
            next_position: 0,
            loads: BTreeMap::new(),
            gone: VecDeque::new(),
            dependants: BTreeMap::new(),
            needed: BTreeMap::new(),
            idle: VecDeque::new(),
            classes: Classes::default(),
            timers: Timers::default(),
            live: Vec::new(),
            gaps: Vec::new(),
            modes: Modes::default(),
            measured: Measured::default(),
            doomed: VecDeque::new(),
            ended: VecDeque::new(),
            armed: Vec::new(),
            armed_for: [None; 2],
            open: 0,
            shutting_down: false,
            looks: 0,
            last: Present::default(),
        }
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
        let mut manager = Self::new(mission);
        Step::new(&mut manager, now, actions).restore(restored);
        manager
    }

    /// Applies everything that happened at this instant, in the order: exits,
    /// what becomes due, tickets and telecommands. Then takes one decision.
    ///
    /// # Timing
    /// Logarithmic in the number of tasks, for each task that the events name;
    /// linear in the kinds of tasks that wait (those that need the same are of
    /// one kind) and in those that run. Becoming due costs a task nothing.
    pub fn step(&mut self, now: Now, events: Vec<Event>, actions: &mut Vec<Action>) {
        Step::new(self, now, actions).apply(events);
    }

    fn entry(&self, index: u32) -> Option<&Entry> {
        self.entries.get(index)
    }

    fn entry_mut(&mut self, index: u32) -> Option<&mut Entry> {
        self.entries.get_mut(index)
    }

    fn named(&self, occurrence: Occurrence) -> Option<u32> {
        let index = *self.by_id.get(&occurrence.task)?;
        (self.entry(index)?.occurrence() == occurrence).then_some(index)
    }

    fn ledger(&self) -> Ledger {
        Ledger::new(&self.installed)
    }
}
