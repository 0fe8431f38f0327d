//! What can be seen of the rover.

use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Duration, Instant};

use super::{ComputerMode, RoverEvent, RoverTruth, World, ZoneTruth};
use crate::rover::model::WindowModel;
use crate::rover::run::RunKey;
use crate::sensors::Measured;

impl World {
    pub(crate) fn truth(&self) -> RoverTruth {
        let (load, peak) = self.loads();
        let zones = self
            .zones
            .iter()
            .map(|zone| ZoneTruth { temperature: zone.temperature(), heater_on: zone.heater_on });
        let running = self.runs.values().filter(|run| !run.stopped);
        let made = self.runs.values().map(|run| run.data());
        RoverTruth {
            charge: Microjoules::new(self.battery.stored_nj() / 1_000),
            load,
            peak,
            // The engines of who stands still are somebody else's to use.
            engines: running.clone().map(|run| run.spec.engines).sum(),
            data: made.fold(self.data, i64::saturating_add),
            mode: self.mode,
            zones: zones.collect(),
            units: self.units.clone(),
        }
    }

    pub(crate) fn gauged(&self) -> Option<Measured<Microjoules>> {
        let Measured { value, measured_at } = self.charge.said()?;
        let value = Microjoules::new(u64::try_from(value).unwrap_or(0)).min(self.model.capacity);
        Some(Measured { value, measured_at })
    }

    pub(crate) fn thermometer(&self, zone: usize) -> Option<Measured<i64>> {
        self.thermometers.get(zone)?.said()
    }

    pub(crate) fn variable(&self, name: &str) -> Option<i64> {
        self.model.variables.get(name).copied()
    }

    pub(crate) fn windows(&self) -> &[WindowModel] {
        &self.model.windows
    }

    pub(crate) fn take_events(&mut self) -> Vec<(Instant, RoverEvent)> {
        std::mem::take(&mut self.events)
    }

    pub(crate) fn data_of(&self, key: RunKey) -> i64 {
        self.runs.get(&key).map_or(0, |run| run.data())
    }

    pub(crate) fn place_is_on(&self, place: usize) -> bool {
        self.runs.values().any(|run| run.spec.place == place && !run.stopped)
    }

    pub(super) fn time_of_day(&self) -> Duration {
        let us = self.model.time_of_day.as_micros().saturating_add(self.now.as_micros());
        Duration::from_micros(us % self.model.day.as_micros().max(1))
    }

    pub(super) fn draw(&self) -> Milliwatts {
        self.model.base.saturating_add(self.loads().0)
    }

    /// Average draw beside the base load, and the largest of what was commanded.
    fn loads(&self) -> (Milliwatts, Milliwatts) {
        let computer = &self.model.computer;
        let of_computer = match self.mode {
            ComputerMode::Asleep => (Milliwatts::ZERO, Milliwatts::ZERO),
            ComputerMode::WakingUp => computer.wakeup,
            ComputerMode::Awake => computer.awake,
            ComputerMode::ShuttingDown => computer.shutdown,
        };
        let is_open = |window: &&WindowModel| window.start <= self.now && self.now < window.end;
        let windows = self.model.windows.iter().filter(is_open).map(|w| (w.average, w.peak));
        let zones = self.zones.iter().enumerate().filter(|(index, zone)| {
            zone.heater_on && !self.script.heater_is_dead(*index, self.now)
        });
        let heaters = zones.map(|(_, zone)| (zone.model.heater, zone.model.peak));
        let runs = self.runs.values().map(|run| (run.average(), run.peak()));
        let (average, peak) = windows.chain(heaters).chain(runs).fold(of_computer, |sum, load| {
            (sum.0.saturating_add(load.0), sum.1.saturating_add(load.1))
        });
        // What nobody commanded is in no sum of what may be commanded.
        (average.saturating_add(self.script.drain(self.now)), peak)
    }
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("World").field("now", &self.now).finish_non_exhaustive()
    }
}
