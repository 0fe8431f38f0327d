//! The numbers of a rover: what is, and not what its planner believes.

use std::collections::BTreeMap;

use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Duration, Instant};

/// A rover.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RoverModel {
    /// What the radioisotope generator gives.
    pub generation: Milliwatts,
    /// What is always drawn.
    pub base: Milliwatts,
    /// What the battery can hold.
    pub capacity: Microjoules,
    /// What it holds at the start.
    pub stored: Microjoules,
    /// The computer.
    pub computer: ComputerModel,
    /// Thermal zones.
    pub zones: Vec<ZoneModel>,
    /// How many units sequences can command: mast, wheels, arm, instruments, and
    /// the sequence engines.
    pub units: usize,
    /// How many sequences can run at a time.
    pub places: usize,
    /// How long a day is.
    pub day: Duration,
    /// The time of day at the clock's start.
    pub time_of_day: Duration,
    /// Communication windows: they open by themselves.
    pub windows: Vec<WindowModel>,
    /// Onboard variables.
    pub variables: BTreeMap<String, i64>,
    /// The sensors.
    pub senses: Senses,
}

/// The computer: what it draws beside the base load, and how long it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComputerModel {
    /// Average and largest draw, awake.
    pub awake: (Milliwatts, Milliwatts),
    /// Average and largest draw, waking up.
    pub wakeup: (Milliwatts, Milliwatts),
    /// Average and largest draw, shutting down.
    pub shutdown: (Milliwatts, Milliwatts),
    /// How long waking up takes.
    pub wakeup_time: Duration,
    /// How long shutting down takes.
    pub shutdown_time: Duration,
    /// Whether it is up at the start.
    pub is_awake: bool,
}

/// A thermal zone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZoneModel {
    /// Average draw of its heater.
    pub heater: Milliwatts,
    /// Largest draw of its heater.
    pub peak: Milliwatts,
    /// How warm it must be, in thousandths of a degree.
    pub needed: i64,
    /// By how many thousandths of a degree it warms in a second of heating.
    pub warms: i64,
    /// By how many it follows its surroundings in a second without.
    pub cools: i64,
    /// How warm the surroundings are from these times of day on; the last row
    /// also holds before the first one.
    pub surroundings: Vec<(Duration, i64)>,
}

/// A communication window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WindowModel {
    /// When it opens.
    pub start: Instant,
    /// When it closes.
    pub end: Instant,
    /// Average draw of the radio.
    pub average: Milliwatts,
    /// Its largest draw.
    pub peak: Milliwatts,
    /// What it adds to the data on board when it closes.
    pub data: i64,
}

/// The sensors: they measure only while the computer is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Senses {
    /// So often they measure.
    pub period: Duration,
    /// So much later the measurement has arrived.
    pub lag: Duration,
    /// The charge is measured so exactly, either way.
    pub charge_noise: Microjoules,
    /// Temperatures are measured so exactly, either way, in thousandths of a
    /// degree.
    pub temperature_noise: i64,
}

impl Default for RoverModel {
    /// About Curiosity's power: a generator of 110 W, a battery of 2.4 kWh at
    /// 60 %, a day of a Martian sol that begins at midnight.
    fn default() -> Self {
        let watt_hours = |wh: u32| Microjoules::from_joules(wh * 3_600);
        Self {
            generation: Milliwatts::from_watts(110),
            base: Milliwatts::from_watts(45),
            capacity: watt_hours(2_400),
            stored: watt_hours(1_440),
            computer: ComputerModel::default(),
            zones: Vec::new(),
            units: 0,
            places: 8,
            day: Duration::from_millis(88_775_244),
            time_of_day: Duration::ZERO,
            windows: Vec::new(),
            variables: BTreeMap::new(),
            senses: Senses::default(),
        }
    }
}

impl Default for ComputerModel {
    fn default() -> Self {
        let [awake, busy] = [90, 110].map(Milliwatts::from_watts);
        Self {
            awake: (awake, busy),
            wakeup: (awake, busy),
            shutdown: (awake, busy),
            wakeup_time: Duration::from_secs(300),
            shutdown_time: Duration::from_secs(180),
            is_awake: false,
        }
    }
}

impl Default for Senses {
    /// Twice in a minute, two seconds late, to half a percent of 2.4 kWh.
    fn default() -> Self {
        Self {
            period: Duration::from_secs(30),
            lag: Duration::from_secs(2),
            charge_noise: Microjoules::from_joules(12 * 3_600),
            temperature_noise: 200,
        }
    }
}
