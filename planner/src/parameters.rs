//! What only the ground changes: limits, powers of what the planner generates,
//! preheat tables. A file of their own.

use std::collections::BTreeMap;

use faregate_tickets::amount::Milliwatts;
use serde::{Deserialize, Serialize};

use crate::units::{Ppm, Span, Time};

/// The parameters of a rover.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Parameters {
    /// Activities of this priority and above are mandatory, the others
    /// optional.
    pub mandatory_from: u32,
    /// No activity is scheduled that would bring the charge below it.
    pub soft_min_soc: Ppm,
    /// What runs below it is aborted.
    pub hard_min_soc: Ppm,
    /// No sleep goes past it.
    pub max_soc: Ppm,
    /// The sum of peaks of what runs at a time.
    pub peak_limit: Milliwatts,
    /// How many sequence engines there are.
    pub engines: u32,
    /// What the radioisotope generator gives, always.
    pub rtg: Milliwatts,
    /// What is always drawn.
    pub base: Milliwatts,
    /// The computer awake: beside the base load.
    pub awake: Load,
    /// Waking up, before an awake phase.
    pub wakeup: Phase,
    /// Shutting down, after one.
    pub shutdown: Phase,
    /// The shortest awake phase, wakeup and shutdown not counted.
    pub min_awake: Span,
    /// The shortest sleep, wakeup and shutdown not counted.
    pub min_sleep: Span,
    /// What time of day it is.
    pub day: Day,
    /// Thermal zones.
    pub zones: Vec<Zone>,
    /// Timelines that activities may name.
    pub timelines: Vec<TimelineSpec>,
    /// Names of resource usage bits, 0 to 127.
    pub resources: BTreeMap<String, u8>,
    /// A new plan leaves alone what starts within this time.
    pub commit: Span,
    /// How long an expanding activity has, once it was told to end.
    pub expansion_grace: Span,
    /// How late a dispatch may be because a device of another activity is still
    /// made safe.
    pub handover_tolerance: Span,
    /// So many estimates in a row below the soft limit abort optional
    /// activities. At least 1.
    pub soft_samples: u32,
}

/// Power that is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Load {
    /// On average, beside what else runs.
    pub marginal: Milliwatts,
    /// At most.
    pub peak: Milliwatts,
}

/// Something that takes a fixed time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Phase {
    /// How long it takes.
    pub duration: Span,
    /// What it draws.
    pub load: Load,
}

/// The day of the place where the rover is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Day {
    /// How long it is.
    pub length: Span,
    /// An instant at which one begins.
    pub midnight: Time,
}

impl Day {
    /// A sol: 24 h 39 min 35.244 s.
    pub const SOL: Self = Self { length: Span::new(88_775_244), midnight: Time::ZERO };

    /// The time since the last midnight.
    #[must_use]
    pub const fn time_of_day(self, at: Time) -> Span {
        Span::new((at.get() - self.midnight.get()).rem_euclid(self.length.get()))
    }
}

impl Default for Day {
    fn default() -> Self {
        Self::SOL
    }
}

/// A thermal zone: what must be warm before its actuators move.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Zone {
    /// Its name.
    pub name: String,
    /// What heating it draws.
    pub load: Load,
    /// How long it must be heated, by the time of day at which the activity
    /// starts. The rows are half-open, in order, and the first begins at 0.
    pub table: Vec<PreheatRow>,
}

impl Zone {
    /// How long it must be heated for an activity that starts at this time of
    /// day.
    #[must_use]
    pub fn preheat(&self, time_of_day: Span) -> Span {
        let row = self.table.iter().take_while(|row| row.from <= time_of_day).last();
        row.map_or(Span::ZERO, |row| row.duration)
    }
}

/// From this time of day on, heating takes so long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct PreheatRow {
    /// Its begin, inclusive; the next row's is its end.
    pub from: Span,
    /// How long heating takes.
    pub duration: Span,
}

/// A timeline that activities may name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimelineSpec {
    /// Its name.
    pub name: String,
    /// How values of it come about.
    pub kind: TimelineKind,
    /// The value where the state says nothing.
    pub initial: i64,
    /// The smallest value that it may ever have.
    pub min: i64,
    /// The largest value that it may ever have.
    pub max: i64,
}

/// The kinds of timelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TimelineKind {
    /// Values that activities set.
    State,
    /// One user at a time.
    Unit,
    /// Held for a time, then given back.
    Renewable,
    /// Used up, or filled; also at rates.
    Consumable,
}
