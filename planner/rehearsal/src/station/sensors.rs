//! What the sensors of places and switches say, and when.

use faregate_agents::{DeviceState, Handle};
use faregate_devices_sim::rover::SWITCH_LAG;
use faregate_tickets::clock::{Clock, Instant};
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::GateId;

use super::{Station, Switch};

/// Whose sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sensor {
    Place(usize),
    Switch(usize),
}

impl Station<'_, '_> {
    /// When a sensor has something to say next.
    pub(crate) fn next_sensed(&self) -> Option<Instant> {
        self.leaving.iter().map(|(due, _)| *due).min()
    }

    /// What the sensors say by now.
    pub(crate) fn sense(&mut self) {
        let now = self.clock.now();
        let (due, later): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.leaving).into_iter().partition(|(due, _)| *due <= now);
        self.leaving = later;
        for (_, sensor) in due {
            let state = self.state(sensor);
            match state {
                DeviceState::Off => {}
                DeviceState::Granted if self.is_on(sensor) => {}
                _ => {
                    self.measure(sensor);
                    self.broker.service();
                    if !matches!(self.state(sensor), DeviceState::Off | DeviceState::Granted) {
                        self.leaving.push((now.after(SWITCH_LAG), sensor));
                    }
                }
            }
        }
    }

    /// What is off was measured just before: whoever gets it in this instant is
    /// seen on later than that.
    pub(super) fn measure(&self, sensor: Sensor) {
        let now = self.clock.now();
        let before = Instant::from_micros(now.as_micros().saturating_sub(1));
        let (state, measured_at) =
            if self.is_on(sensor) { (Power::On, now) } else { (Power::Off, before) };
        if let Some(gate) = self.gate(sensor) {
            self.broker.observe(gate, Estimate { state, measured_at });
        }
    }

    pub(super) fn is_on(&self, sensor: Sensor) -> bool {
        match sensor {
            Sensor::Place(place) => self.rover.place_is_on(place),
            Sensor::Switch(switch) => {
                let truth = self.rover.truth();
                match self.parts.switch(switch) {
                    Switch::Unit(unit) => truth.units.get(unit).copied().unwrap_or(false),
                    Switch::Heater(zone) => truth.zones.get(zone).is_some_and(|one| one.heater_on),
                    Switch::Computer => false,
                }
            }
        }
    }

    pub(super) fn gate(&self, sensor: Sensor) -> Option<GateId> {
        match sensor {
            Sensor::Place(place) => self.places.get(place).map(|one| one.handle.gate()),
            Sensor::Switch(switch) => self.switches.get(switch).map(Handle::gate),
        }
    }

    pub(super) fn state(&self, sensor: Sensor) -> DeviceState {
        let report = self.gate(sensor).and_then(|gate| self.broker.device(gate));
        report.map_or(DeviceState::Leaving, |report| report.state)
    }
}
