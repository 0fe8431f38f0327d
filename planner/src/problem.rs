//! A problem: plan, parameters and state, made ready for arithmetic that cannot
//! overflow. Names are indices here, limits of the state of charge are charges,
//! and instants, powers and charges are plain integers in ms, mW and uJ.

mod build;
mod unfit;

pub use unfit::Unfit;

use crate::parameters::{Day, Load, Parameters, PreheatRow};
use crate::plan::{Dependency, Kind, Outcome, Plan};
use crate::state::{Mode, State};
use crate::units::Ppm;

/// What is to be planned: checked, and indexed.
#[derive(Clone, Debug)]
pub struct Problem {
    pub(crate) plan: Plan,
    pub(crate) parameters: Parameters,
    pub(crate) state: State,
    pub(crate) now: i64,
    pub(crate) end: i64,
    /// When the minimum at handover is looked at; none: that was before now.
    pub(crate) handover: Option<i64>,
    /// One for each activity, in the plan's order.
    pub(crate) items: Vec<Item>,
    pub(crate) battery: Battery,
    pub(crate) computer: Computer,
    pub(crate) zones: Vec<ZoneModel>,
    /// Manual shutdowns that are not over, in order.
    pub(crate) blocks: Vec<Block>,
    /// Candidates, the most important first.
    pub(crate) order: Vec<usize>,
    pub(crate) peak_limit: i64,
    pub(crate) commit: i64,
}

/// An activity.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    /// What is known of it already.
    pub(crate) fate: Known,
    pub(crate) mandatory: bool,
    pub(crate) cleanup: bool,
    pub(crate) expanding: bool,
    /// What it is placed with, and how long it may become.
    pub(crate) shortest: i64,
    pub(crate) longest: i64,
    pub(crate) draw: Draw,
    /// Zones by index, each once.
    pub(crate) zones: Vec<usize>,
    /// Starts that its range, its cutoff and the plan's end leave.
    pub(crate) ranges: Vec<Range>,
    pub(crate) after: Vec<(usize, Dependency)>,
    pub(crate) group: Option<usize>,
}

/// What is known of an activity before anything is planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Known {
    /// It may be planned.
    Open,
    /// A manual shutdown: the ground's own time, if that is not over.
    Block(Option<(i64, i64)>),
    /// It runs, and is thought to until then.
    Running { start: i64, end: i64, paused: bool },
    /// It has ended; with its use of zones.
    Ended { outcome: Outcome, used: Option<(i64, i64)> },
}

/// What is drawn: on average, and at most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Draw {
    pub(crate) marginal: i64,
    pub(crate) peak: i64,
}

/// Starts, both ends inclusive. Empty where `to` is before `from`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub(crate) from: i64,
    pub(crate) to: i64,
    /// The latest end: the cutoff, or the plan's end.
    pub(crate) last: i64,
}

/// Charges in uJ, powers in mW.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Battery {
    pub(crate) charge: i64,
    pub(crate) capacity: i64,
    pub(crate) soft: i64,
    pub(crate) handover: i64,
    pub(crate) max: i64,
    /// What comes in with nothing but the base load.
    pub(crate) idle: i64,
}

/// What the computer needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Computer {
    pub(crate) mode: Mode,
    pub(crate) since: i64,
    pub(crate) awake: Draw,
    pub(crate) wakeup: Draw,
    pub(crate) shutdown: Draw,
    pub(crate) wakeup_time: i64,
    pub(crate) shutdown_time: i64,
    pub(crate) min_awake: i64,
    pub(crate) min_sleep: i64,
}

/// A thermal zone.
#[derive(Clone, Debug)]
pub(crate) struct ZoneModel {
    pub(crate) name: String,
    pub(crate) draw: Draw,
    pub(crate) day: Day,
    pub(crate) table: Vec<PreheatRow>,
    /// Heated since then.
    pub(crate) heating: Option<i64>,
    /// Found unfit: what it was used for before does not count.
    pub(crate) cold: bool,
}

/// A manual shutdown, sleep and wakeup. Shutdown and wakeup never overlap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) from: i64,
    pub(crate) shutdown_until: i64,
    pub(crate) wakeup_from: i64,
    pub(crate) to: i64,
}

impl Problem {
    /// Checks and indexes. Nothing that is planned from it can overflow.
    ///
    /// # Errors
    ///
    /// Everything that the three do not agree on, or that is out of bounds.
    pub fn new(plan: &Plan, parameters: &Parameters, state: &State) -> Result<Self, Vec<Unfit>> {
        build::build(plan, parameters, state)
    }

    /// The plan that it was made from.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The parameters that it was made from.
    #[must_use]
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The state that it was made from.
    #[must_use]
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// Indices of the candidates, in the plan file's numbering, the most
    /// important first; among equals, in the file's order.
    #[must_use]
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// The same with a soft minimum of so many millionths.
    pub(crate) fn with_soft(mut self, soft: Ppm) -> Self {
        self.battery.soft = build::fraction(soft, self.battery.capacity).0;
        self
    }

    /// The same with a minimum at handover of so many millionths.
    pub(crate) fn with_handover(mut self, handover: Ppm) -> Self {
        self.battery.handover = build::fraction(handover, self.battery.capacity).0;
        self
    }

    /// The next manual block that begins at `at` or later.
    pub(crate) fn next_block(&self, at: i64) -> Option<&Block> {
        self.blocks.get(self.blocks.partition_point(|block| block.from < at))
    }

    /// The block that `now` is in.
    pub(crate) fn present_block(&self) -> Option<&Block> {
        self.blocks.first().filter(|block| block.from <= self.now)
    }
}

impl Item {
    /// Whether it is for the planner to place.
    pub(crate) fn is_candidate(&self) -> bool {
        self.fate == Known::Open
    }
}

impl ZoneModel {
    /// How long it is heated for a use at `start`, and until which start this
    /// is so, exclusive.
    pub(crate) fn preheat(&self, start: i64) -> (i64, i64) {
        let time = self.day.time_of_day(crate::units::Time::new(start));
        let later = self.table.partition_point(|row| row.from <= time);
        let row = later.checked_sub(1).and_then(|row| self.table.get(row));
        let until = self.table.get(later).map_or(self.day.length, |row| row.from);
        (row.map_or(0, |row| row.duration.get()), start + until.get() - time.get())
    }
}

impl From<Load> for Draw {
    /// Both were checked to be small before.
    fn from(load: Load) -> Self {
        Self { marginal: build::small(load.marginal), peak: build::small(load.peak) }
    }
}

/// Whether it is placed at its minimum first.
pub(crate) const fn is_expanding(kind: Kind) -> bool {
    matches!(kind, Kind::Expanding { .. })
}
