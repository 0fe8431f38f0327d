//! What drivers and sequences do to the rover.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

use super::{ComputerMode, RoverEvent, World};
use crate::rover::run::{Run, RunKey, RunSpec};

impl World {
    pub(crate) fn take_place(&mut self, place: usize) -> bool {
        take(&mut self.taken.places, place)
    }

    pub(crate) fn take_unit(&mut self, unit: usize) -> bool {
        take(&mut self.taken.units, unit)
    }

    pub(crate) fn take_heater(&mut self, zone: usize) -> Option<Milliwatts> {
        let zone = self.zones.get_mut(zone).filter(|zone| !zone.driver_taken)?;
        zone.driver_taken = true;
        Some(zone.model.peak)
    }

    pub(crate) fn take_computer(&mut self) -> bool {
        !std::mem::replace(&mut self.taken.computer, true)
    }

    pub(crate) fn switch_unit(&mut self, unit: usize, on: bool) -> bool {
        self.units.get_mut(unit).map(|switch| *switch = on).is_some()
    }

    pub(crate) fn switch_heater(&mut self, now: Instant, zone: usize, on: bool) -> bool {
        self.advance_to(now);
        // The computer has to watch over what is heated.
        let is_up = self.mode == ComputerMode::Awake;
        let found = self.zones.get_mut(zone).map(|zone| zone.heater_on = on && is_up).is_some();
        self.see();
        found
    }

    pub(crate) fn switch_computer(&mut self, now: Instant, on: bool) -> bool {
        self.advance_to(now);
        let computer = self.model.computer;
        match (self.mode, on) {
            (ComputerMode::Asleep, true) => {
                self.enter(ComputerMode::WakingUp);
                self.mode_ends = Some(now.after(computer.wakeup_time));
            }
            (ComputerMode::Awake, false) => self.shut_down(now),
            _ => {}
        }
        self.see();
        true
    }

    /// Nothing that needs the computer outlives it.
    fn shut_down(&mut self, now: Instant) {
        self.zones.iter_mut().for_each(|zone| zone.heater_on = false);
        let keys: Vec<_> = self.runs.keys().copied().collect();
        for key in keys {
            self.stop_run(key);
        }
        self.enter(ComputerMode::ShuttingDown);
        self.mode_ends = Some(now.after(self.model.computer.shutdown_time));
    }

    pub(crate) fn set_computer_times(&mut self, wakeup: Duration, shutdown: Duration) {
        self.model.computer.wakeup_time = wakeup;
        self.model.computer.shutdown_time = shutdown;
    }

    pub(crate) fn start(&mut self, now: Instant, key: RunKey, spec: RunSpec) {
        self.advance_to(now);
        self.runs.insert(key, Run::new(spec));
        self.see();
    }

    pub(crate) fn pause(&mut self, now: Instant, key: RunKey) {
        self.advance_to(now);
        self.stop_run(key);
        self.see();
    }

    pub(crate) fn resume(&mut self, now: Instant, key: RunKey) {
        self.advance_to(now);
        if let Some(run) = self.runs.get_mut(&key) {
            run.stopped = false;
        }
        self.see();
    }

    pub(crate) fn tell_to_end(&mut self, now: Instant, key: RunKey) {
        self.advance_to(now);
        if let Some(run) = self.runs.get_mut(&key) {
            run.tell_to_end();
        }
    }

    /// Whatever runs in this place stands still from now on.
    pub(crate) fn stop(&mut self, now: Instant, place: usize) {
        self.advance_to(now);
        let keys = self.runs.iter().filter(|(_, run)| run.spec.place == place);
        let keys: Vec<_> = keys.map(|(key, _)| *key).collect();
        for key in keys {
            self.stop_run(key);
        }
        self.see();
    }

    fn stop_run(&mut self, key: RunKey) {
        let Some(run) = self.runs.get_mut(&key).filter(|run| !run.stopped) else { return };
        run.stopped = true;
        self.events.push((self.now, RoverEvent::Stopped(key)));
    }

    pub(crate) fn give_up(&mut self, now: Instant, key: RunKey) -> i64 {
        self.advance_to(now);
        let data = self.runs.remove(&key).map_or(0, |run| run.data());
        self.data = self.data.saturating_add(data);
        self.see();
        data
    }

    fn see(&mut self) {
        self.battery.see(self.draw(), self.model.generation);
    }
}

fn take(taken: &mut [bool], index: usize) -> bool {
    taken.get_mut(index).is_some_and(|taken| !std::mem::replace(taken, true))
}
