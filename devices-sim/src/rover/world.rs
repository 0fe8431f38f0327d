//! The rover's physics, from instant to instant, exactly.

mod commands;
mod happen;
mod looks;

use std::collections::BTreeMap;

use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::Instant;

use super::faults::RoverScript;
use super::gauge::Gauge;
use super::model::RoverModel;
use super::run::{Run, RunKey};
use super::thermal::{self, Zone};
use crate::battery::Battery;
use crate::parameters::Parameters;

/// What the computer does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComputerMode {
    /// Sleeps.
    Asleep,
    /// Wakes up.
    WakingUp,
    /// Is up.
    Awake,
    /// Shuts down.
    ShuttingDown,
}

/// Something that happened by itself, or was found out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RoverEvent {
    /// A sequence ended by itself.
    Finished {
        /// Which one.
        key: RunKey,
        /// Whether it did its work.
        succeeded: bool,
        /// What it added to the data on board.
        data: i64,
    },
    /// A sequence stands still: its place was made safe.
    Stopped(RunKey),
    /// The computer begins to do this.
    Computer(ComputerMode),
    /// The sensors have something new to say.
    Sensed,
    /// A variable changed.
    Variable(String),
    /// A window opened or closed.
    Window {
        /// Which one.
        index: usize,
        /// Whether it opened.
        open: bool,
    },
    /// The windows are not what they were.
    Replanned,
}

/// How a rover really stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RoverTruth {
    /// What the battery holds.
    pub charge: Microjoules,
    /// What is drawn on average, beside the base load.
    pub load: Milliwatts,
    /// The sum of what can be drawn at most by what was commanded, beside the
    /// base load.
    pub peak: Milliwatts,
    /// Sequence engines in use.
    pub engines: u32,
    /// What was added to the data on board.
    pub data: i64,
    /// What the computer does.
    pub mode: ComputerMode,
    /// The zones, in their order.
    pub zones: Vec<ZoneTruth>,
    /// Which units are on.
    pub units: Vec<bool>,
}

/// How a zone really stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZoneTruth {
    /// How warm it is, in thousandths of a degree.
    pub temperature: i64,
    /// Whether its heater is on.
    pub heater_on: bool,
}

pub(crate) struct World {
    now: Instant,
    model: RoverModel,
    script: RoverScript,
    battery: Battery,
    mode: ComputerMode,
    /// When the computer has woken up, or shut down.
    mode_ends: Option<Instant>,
    zones: Vec<Zone>,
    units: Vec<bool>,
    taken: Taken,
    runs: BTreeMap<RunKey, Run>,
    /// Data of what has ended, and of windows.
    data: i64,
    charge: Gauge,
    thermometers: Vec<Gauge>,
    events: Vec<(Instant, RoverEvent)>,
}

/// Which drivers were taken.
struct Taken {
    places: Vec<bool>,
    units: Vec<bool>,
    computer: bool,
}

impl World {
    pub(crate) fn new(model: RoverModel, script: RoverScript, seed: u64, now: Instant) -> Self {
        let time_of_day = model.time_of_day;
        let zones = model.zones.iter().map(|zone| Zone::new(zone.clone(), time_of_day));
        let noise = i64::try_from(model.senses.charge_noise.get()).unwrap_or(i64::MAX / 4);
        let warmth = model.senses.temperature_noise;
        let thermometers = (1..).zip(&model.zones).map(|(n, _)| Gauge::new(warmth, seed, n));
        let supply = Parameters {
            battery_capacity: model.capacity,
            battery_stored: model.stored,
            ..Parameters::default()
        };
        let awake = model.computer.is_awake;
        let mut world = Self {
            now,
            battery: Battery::new(&supply),
            mode: if awake { ComputerMode::Awake } else { ComputerMode::Asleep },
            mode_ends: None,
            zones: zones.collect(),
            units: vec![false; model.units],
            taken: Taken {
                places: vec![false; model.places],
                units: vec![false; model.units],
                computer: false,
            },
            runs: BTreeMap::new(),
            data: 0,
            charge: Gauge::new(noise, seed, 0),
            thermometers: thermometers.collect(),
            events: Vec::new(),
            model,
            script,
        };
        world.happen();
        world
    }

    /// Lets the physics catch up with the clock.
    pub(crate) fn advance_to(&mut self, target: Instant) {
        while let Some(next) = self.next_event().filter(|at| *at <= target) {
            self.pass_until(next);
            self.happen();
        }
        self.pass_until(target);
    }

    /// When something happens next by itself.
    pub(crate) fn next_event(&self) -> Option<Instant> {
        let windows = self.model.windows.iter().flat_map(|window| [window.start, window.end]);
        let later = |at: &Instant| *at > self.now;
        let time_of_day = self.time_of_day();
        self.runs
            .values()
            .filter_map(|run| run.ends(self.now))
            .chain(self.mode_ends)
            .chain(windows.filter(later))
            .chain(self.script.next_after(self.now))
            .chain(thermal::next_row(&self.zones, self.now, time_of_day, self.model.day))
            .chain(self.battery.flat_at(self.now, self.draw(), self.model.generation))
            .chain(self.next_measurement())
            .min()
    }

    /// The sensors measure in step with the clock, while the computer is up.
    fn next_measurement(&self) -> Option<Instant> {
        let senses = &self.model.senses;
        let period = senses.period.as_micros().max(1);
        let since = self.now.as_micros() % period;
        let measured = self.now.as_micros() - since;
        let arrives = Instant::from_micros(measured).after(senses.lag);
        let next = Instant::from_micros(measured.saturating_add(period));
        let is_up = self.mode == ComputerMode::Awake;
        is_up.then(|| if arrives > self.now { arrives } else { next })
    }

    fn pass_until(&mut self, at: Instant) {
        let time = at.since(self.now);
        let (draw, time_of_day) = (self.draw(), self.time_of_day());
        self.battery.pass(time, draw, self.model.generation);
        for (index, zone) in self.zones.iter_mut().enumerate() {
            let used = self.runs.values().any(|run| run.spec.zones.contains(&index));
            let warms = zone.heater_on && !self.script.heater_is_dead(index, self.now);
            zone.pass(time, warms, used, time_of_day);
        }
        self.runs.values_mut().for_each(|run| run.pass(time));
        self.now = at;
    }
}
