//! What is so now: the estimates that a plan is made from.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use serde::{Deserialize, Serialize};

use crate::plan::{ActivityId, Outcome};
use crate::units::{Bytes, Time};

/// The present state.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct State {
    /// The present instant.
    pub now: Time,
    /// What the computer does.
    pub mode: Mode,
    /// Since when: what has passed of a mode counts.
    pub mode_since: Time,
    /// The estimate of the battery's charge.
    pub charge: Microjoules,
    /// The estimate of what the battery can hold.
    pub capacity: Microjoules,
    /// Thermal zones that are being heated, and since when.
    pub heating: BTreeMap<String, Time>,
    /// Thermal zones that were found unfit, though the plan had them warm: they
    /// are heated again from scratch.
    pub cold: Vec<String>,
    /// Onboard variables, saved and unsaved.
    pub variables: BTreeMap<String, i64>,
    /// Values of named timelines.
    pub timelines: BTreeMap<String, i64>,
    /// Activities that have ended.
    pub ended: Vec<Ended>,
    /// Activities that run, or are paused.
    pub running: Vec<Running>,
    /// Communication windows, as last queried. Those that are over stay here:
    /// their data counts, as that of ended activities does.
    pub windows: Vec<Window>,
}

impl State {
    /// The communication windows are these. One that is over and that nobody
    /// lists any more has taken place all the same: what was sent in it is on
    /// board no more.
    pub fn queried(&mut self, windows: Vec<Window>) {
        let known = std::mem::replace(&mut self.windows, windows);
        let is_listed = |old: &Window| {
            self.windows.iter().any(|new| (&new.name, new.start) == (&old.name, old.start))
        };
        let over = known.into_iter().filter(|old| old.end <= self.now && !is_listed(old));
        let over: Vec<_> = over.collect();
        self.windows.splice(..0, over);
    }

    /// What windows that are over have brought on board, or sent.
    #[must_use]
    pub fn exchanged(&self) -> i128 {
        let over = self.windows.iter().filter(|window| window.end <= self.now);
        over.map(|window| i128::from(window.data.get())).sum()
    }
}

/// What the computer does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Mode {
    /// Sleeps.
    #[default]
    Asleep,
    /// Wakes up.
    WakingUp,
    /// Is up.
    Awake,
    /// Shuts down.
    ShuttingDown,
}

/// An activity that has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Ended {
    /// Which one.
    pub id: ActivityId,
    /// How.
    pub outcome: Outcome,
    /// When it started; none: never.
    pub started: Option<Time>,
    /// When it ended.
    pub ended: Time,
    /// What it really added to the data on board.
    pub data: Bytes,
}

/// An activity that runs, or is paused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Running {
    /// Which one.
    pub id: ActivityId,
    /// When it started.
    pub started: Time,
    /// Its planned end: later by the time that it was paused.
    pub ends: Time,
    /// When it must be over.
    pub cutoff: Time,
    /// Since when it is paused; none: it runs.
    pub paused: Option<Time>,
    /// What it has added to the data on board so far.
    pub data: Bytes,
}

/// A communication window: made elsewhere, planned around.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// What people call it.
    pub name: String,
    /// When it begins.
    pub start: Time,
    /// When it is over.
    pub end: Time,
    /// Whether the computer must be awake for it.
    pub awake: bool,
    /// Average power.
    pub marginal: Milliwatts,
    /// Largest power.
    pub peak: Milliwatts,
    /// What it adds to the data on board, at its end where it is negative; when
    /// it is over, what it really added.
    pub data: Bytes,
    /// Sequence engines.
    pub engines: u32,
    /// Resource usage bits.
    pub resources: Categories,
}
