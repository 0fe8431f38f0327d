//! What is given before anything is decided: the plan, the parameters, the
//! state, and what stands in every world (running activities, manual blocks,
//! committed slots).

use std::collections::BTreeMap;

use faregate_planner::plan::{Activity, ActivityId, Kind};
use faregate_planner::state::{Ended, Running};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::units::{Ppm, Time};
use faregate_planner::{Parameters, Plan, State};

/// An activity at a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Placed {
    /// Its place in the plan.
    pub(crate) index: usize,
    pub(crate) start: i64,
    pub(crate) end: i64,
    pub(crate) how: How,
}

/// How it came to its slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum How {
    Runs { paused: bool },
    Block { shutdown: i64, wakeup: i64 },
    Committed,
    Chosen,
}

/// Everything that is given.
#[derive(Debug)]
pub(crate) struct Scene<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) parameters: &'a Parameters,
    pub(crate) state: &'a State,
    pub(crate) now: i64,
    pub(crate) end: i64,
    pub(crate) incumbent: bool,
    /// Running, manual blocks, committed: what no decision moves.
    pub(crate) fixed: Vec<Placed>,
    indices: BTreeMap<ActivityId, usize>,
}

impl<'a> Scene<'a> {
    pub(crate) fn new(
        plan: &'a Plan,
        parameters: &'a Parameters,
        state: &'a State,
        incumbent: Option<&TimedPlan>,
    ) -> Self {
        let indices = plan.activities.iter().enumerate().map(|(i, a)| (a.id, i)).collect();
        let mut scene = Self {
            plan,
            parameters,
            state,
            now: state.now.get(),
            end: plan.end.get(),
            incumbent: incumbent.is_some(),
            fixed: Vec::new(),
            indices,
        };
        scene.fixed = scene.running().chain(scene.blocks()).collect();
        if let Some(incumbent) = incumbent {
            let committed: Vec<Placed> = scene.committed(incumbent).collect();
            scene.fixed.extend(committed);
        }
        scene
    }

    pub(crate) fn activity(&self, index: usize) -> &'a Activity {
        &self.plan.activities[index]
    }

    pub(crate) fn index(&self, id: ActivityId) -> Option<usize> {
        self.indices.get(&id).copied()
    }

    pub(crate) fn ended(&self, id: ActivityId) -> Option<&'a Ended> {
        self.state.ended.iter().find(|ended| ended.id == id)
    }

    pub(crate) fn is_running(&self, id: ActivityId) -> bool {
        self.state.running.iter().any(|running| running.id == id)
    }

    pub(crate) fn is_optional(&self, index: usize) -> bool {
        self.activity(index).priority < self.parameters.mandatory_from
    }

    /// The earliest start that a candidate may have.
    pub(crate) fn earliest(&self, index: usize) -> i64 {
        match (self.incumbent, self.activity(index).kind) {
            (true, Kind::Generic | Kind::Expanding { .. } | Kind::StayAwake) => {
                self.now + self.parameters.commit.get()
            }
            _ => self.now,
        }
    }

    /// A minimum state of charge as a charge: rounded to the safe side.
    pub(crate) fn at_least(&self, ppm: Ppm) -> i128 {
        let product = i128::from(ppm.get()) * self.capacity();
        -((-product).div_euclid(1_000_000))
    }

    /// A maximum state of charge as a charge: rounded to the safe side.
    pub(crate) fn at_most(&self, ppm: Ppm) -> i128 {
        (i128::from(ppm.get()) * self.capacity()).div_euclid(1_000_000)
    }

    pub(crate) fn capacity(&self) -> i128 {
        i128::from(self.state.capacity.get())
    }

    /// Manual blocks that are not over, in order of time.
    pub(crate) fn manual(&self) -> Vec<Placed> {
        let is_block = |placed: &&Placed| matches!(placed.how, How::Block { .. });
        let mut blocks: Vec<Placed> = self.fixed.iter().filter(is_block).copied().collect();
        blocks.sort_by_key(|block| block.start);
        blocks
    }

    fn running(&self) -> impl Iterator<Item = Placed> {
        self.state.running.iter().filter_map(|running| {
            let end = self.planned_end(running);
            let how = How::Runs { paused: running.paused.is_some() };
            let start = running.started.get();
            self.index(running.id).map(|index| Placed { index, start, end, how })
        })
    }

    /// A running one that should be over is looked at again a little later.
    fn planned_end(&self, running: &Running) -> i64 {
        let late = self.parameters.commit.get().max(1_000);
        if running.ends > self.state.now { running.ends.get() } else { self.now + late }
    }

    fn blocks(&self) -> impl Iterator<Item = Placed> {
        self.plan.activities.iter().enumerate().filter_map(|(index, activity)| {
            let placed = block(index, activity)?;
            let over = self.ended(activity.id).is_some() || self.is_running(activity.id);
            (placed.end > self.now && !over).then_some(placed)
        })
    }

    fn committed(&self, incumbent: &TimedPlan) -> impl Iterator<Item = Placed> {
        let window = self.now..self.now + self.parameters.commit.get();
        incumbent.rows.iter().filter_map(move |row| {
            let Fate::Scheduled(slot) = row.fate else { return None };
            let index = self.index(row.id)?;
            let gone = self.ended(row.id).is_some() || self.is_running(row.id);
            let manual = block(index, self.activity(index)).is_some();
            let (start, end) = (slot.start.get(), slot.end.get());
            (window.contains(&start) && !gone && !manual).then_some(Placed {
                index,
                start,
                end,
                how: How::Committed,
            })
        })
    }
}

/// The block of a manual shutdown.
pub(crate) fn block(index: usize, activity: &Activity) -> Option<Placed> {
    let Kind::ManualShutdown { shutdown, wakeup } = activity.kind else { return None };
    let start = activity.starts.first()?.from;
    let how = How::Block { shutdown: shutdown.get(), wakeup: wakeup.get() };
    let end = start.after(activity.duration).get();
    Some(Placed { index, start: start.get(), end, how })
}

/// Names of zones, each once.
pub(crate) fn zones(activity: &Activity) -> impl Iterator<Item = &str> {
    let zones = &activity.zones;
    zones
        .iter()
        .enumerate()
        .filter(|(i, zone)| !zones[..*i].contains(zone))
        .map(|(_, z)| z.as_str())
}

pub(crate) fn time(ms: i64) -> Time {
    Time::new(ms)
}
