//! What happens by itself, at its instant.

use faregate_tickets::clock::Duration;

use super::{ComputerMode, RoverEvent, World};
use crate::rover::faults::RoverFault;
use crate::rover::gauge::Gauge;
use crate::rover::model::WindowModel;

impl World {
    /// What happens at this instant.
    pub(super) fn happen(&mut self) {
        self.end_mode();
        self.end_runs();
        self.windows_happen();
        self.faults_happen();
        self.sense();
        self.battery.see(self.draw(), self.model.generation);
    }

    fn end_mode(&mut self) {
        if self.mode_ends.is_none_or(|ends| ends > self.now) {
            return;
        }
        self.mode_ends = None;
        match self.mode {
            ComputerMode::WakingUp => self.enter(ComputerMode::Awake),
            ComputerMode::ShuttingDown => self.enter(ComputerMode::Asleep),
            ComputerMode::Awake | ComputerMode::Asleep => {}
        }
    }

    pub(super) fn enter(&mut self, mode: ComputerMode) {
        self.mode = mode;
        self.events.push((self.now, RoverEvent::Computer(mode)));
        if mode != ComputerMode::Awake {
            // Nobody is there to read what is on its way.
            self.charge.forget();
            self.thermometers.iter_mut().for_each(Gauge::forget);
        } else if !self.script.is_silent(self.now) {
            // Who wakes up looks around first.
            self.measure();
            let lag = Duration::ZERO;
            self.charge.arrive(self.now, lag);
            self.thermometers.iter_mut().for_each(|one| one.arrive(self.now, lag));
            self.events.push((self.now, RoverEvent::Sensed));
        }
    }

    fn end_runs(&mut self) {
        let over: Vec<_> =
            self.runs.iter().filter(|(_, run)| run.is_over()).map(|(key, _)| *key).collect();
        for key in over {
            let Some(run) = self.runs.remove(&key) else { continue };
            let data = run.data();
            self.data = self.data.saturating_add(data);
            let event = RoverEvent::Finished { key, succeeded: run.succeeded(), data };
            self.events.push((self.now, event));
        }
    }

    fn windows_happen(&mut self) {
        for (index, window) in self.model.windows.iter().enumerate() {
            for (at, open) in [(window.start, true), (window.end, false)] {
                if at == self.now && window.start < window.end {
                    self.events.push((self.now, RoverEvent::Window { index, open }));
                    self.data = self.data.saturating_add(if open { 0 } else { window.data });
                }
            }
        }
    }

    fn faults_happen(&mut self) {
        let faults: Vec<_> = self.script.at(self.now).cloned().collect();
        for fault in faults {
            match fault {
                RoverFault::Discharge { energy, .. } => self.battery.lose(energy),
                RoverFault::Variable { name, value, .. } => self.set_variable(name, value),
                RoverFault::Window { index, becomes, .. } => self.replace_window(index, becomes),
                RoverFault::HeaterDead { .. }
                | RoverFault::SensorsSilent { .. }
                | RoverFault::Drain { .. } => {}
            }
        }
    }

    fn set_variable(&mut self, name: String, value: Option<i64>) {
        self.events.push((self.now, RoverEvent::Variable(name.clone())));
        match value {
            Some(value) => self.model.variables.insert(name, value),
            None => self.model.variables.remove(&name),
        };
    }

    /// A window that has opened stays as it is.
    fn replace_window(&mut self, index: usize, becomes: Option<WindowModel>) {
        let now = self.now;
        let Some(window) = self.model.windows.get_mut(index).filter(|w| w.start > now) else {
            return;
        };
        let cancelled = WindowModel { end: window.start, ..*window };
        *window = becomes.filter(|new| new.start > now).unwrap_or(cancelled);
        self.events.push((self.now, RoverEvent::Replanned));
    }

    fn sense(&mut self) {
        if self.mode != ComputerMode::Awake {
            return;
        }
        let senses = self.model.senses;
        let period = senses.period.as_micros().max(1);
        if self.now.as_micros().is_multiple_of(period) && !self.script.is_silent(self.now) {
            self.measure();
        }
        let before = self.charge.said();
        self.charge.arrive(self.now, senses.lag);
        self.thermometers.iter_mut().for_each(|one| one.arrive(self.now, senses.lag));
        if self.charge.said() != before {
            self.events.push((self.now, RoverEvent::Sensed));
        }
    }

    fn measure(&mut self) {
        let charge = i64::try_from(self.battery.stored_nj() / 1_000).unwrap_or(i64::MAX / 4);
        self.charge.measure(self.now, charge);
        for (gauge, zone) in self.thermometers.iter_mut().zip(&self.zones) {
            gauge.measure(self.now, zone.temperature());
        }
    }
}
