//! The spacecraft's physics: from event to event, exactly.
//!
//! Between two events every rate is constant, so integration is one
//! multiplication, and the result does not depend on how often anybody looks.

use std::borrow::Cow;

use faregate_tickets::amount::{Microjoules, MilligramsPerSecond, Milliwatts};
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::Estimate;

use crate::battery::Battery;
use crate::camera::CameraState;
use crate::cutoff::CutoffState;
use crate::device::{Command, DeviceId};
use crate::faults::{Failing, Fault, FaultScript};
use crate::heaters::HeatersState;
use crate::law::Law;
use crate::parameters::{COMMAND_TIME_MAX, Parameters, THRUSTER_FLOW};
use crate::power::Supply;
use crate::propulsion::{Spin, Tank};
use crate::random::Dice;
use crate::sensors::{History, Measured, Sensor};
use crate::thruster::ThrusterState;
use crate::trace::{Outcome, ReceivedCommand};

/// What a device made of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reaction {
    Took,
    NoEffect,
}

/// What the checkers of a simulation see, and flight software never does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Truth {
    /// The instant of all this; that of the loss, once the spacecraft is lost.
    pub at: Instant,
    /// What the bus can give.
    pub supply: Milliwatts,
    /// What is drawn from it.
    pub draw: Milliwatts,
    /// What the battery holds, in nanojoules.
    pub stored_nj: u64,
    /// Whether the camera's switch is closed.
    pub camera_on: bool,
    /// Exposures that finished by their deadline.
    pub exposures_finished: u32,
    /// Exposures that were cut short.
    pub exposures_lost: u32,
    /// Exposures that finished after their deadline.
    pub exposures_late: u32,
    /// Whether the thruster valve is open, driven or stuck.
    pub thruster_open: bool,
    /// Whether the cutoff valve is shut.
    pub cutoff_shut: bool,
    /// Whether the cutoff valve's coil is driven.
    pub cutoff_coil_on: bool,
    /// Whether the heaters are on.
    pub heaters_on: bool,
    /// The body's rate, in microradians per second.
    pub rate_urad_s: u64,
    /// Propellant left, in nanograms.
    pub propellant_ng: u64,
}

impl Truth {
    /// What the battery holds, in whole microjoules.
    #[must_use]
    pub fn stored(&self) -> Microjoules {
        Microjoules::new(self.stored_nj / 1_000)
    }
}

/// What the driver has to do with a command that it just received.
pub(crate) struct Begun {
    pub(crate) entry: usize,
    pub(crate) time: Duration,
    pub(crate) failing: Option<Failing>,
}

#[derive(Debug)]
pub(crate) struct Plant {
    pub(crate) parameters: Parameters,
    script: FaultScript,
    dice: Dice,
    now: Instant,
    broken: Option<(Instant, Law)>,
    generation: Milliwatts,
    battery: Battery,
    bus: Supply,
    propulsion: Supply,
    camera: CameraState,
    thruster: ThrusterState,
    cutoff: CutoffState,
    heaters: HeatersState,
    tank: Tank,
    spin: Spin,
    offs_ignored: u32,
    received: [u32; 4],
    trace: Vec<ReceivedCommand>,
    sensors: Sensors,
}

/// The sensors, and what they look at.
#[derive(Debug)]
struct Sensors {
    of_device: [Sensor; 4],
    of_body: Sensor,
    switches: [History<bool>; 4],
    cutoff_shut: History<bool>,
    exposures: History<u32>,
    spin: History<Spin>,
}

impl Plant {
    pub(crate) fn new(parameters: Parameters, script: FaultScript, seed: u64) -> Self {
        let mut plant = Self {
            dice: Dice::new(seed, 4),
            now: Instant::START,
            broken: None,
            generation: parameters.generation,
            battery: Battery::new(&parameters),
            bus: Supply::new(parameters.bus_trip_time),
            propulsion: Supply::new(parameters.propulsion_trip_time),
            camera: CameraState::new(),
            thruster: ThrusterState::default(),
            cutoff: CutoffState::default(),
            heaters: HeatersState::default(),
            tank: Tank::new(&parameters),
            spin: Spin::new(&parameters),
            offs_ignored: 0,
            received: [0; 4],
            trace: Vec::new(),
            sensors: Sensors::new(seed, &parameters),
            parameters,
            script,
        };
        plant.happen();
        plant
    }

    /// Lets the physics catch up with the clock. Nothing happens after a loss.
    pub(crate) fn advance_to(&mut self, target: Instant) {
        while self.broken.is_none() && self.now < target {
            let next = self.next_event().filter(|at| *at <= target);
            self.pass_until(next.unwrap_or(target));
            self.check_laws();
            if next.is_some() && self.broken.is_none() {
                self.happen();
            }
        }
    }

    fn next_event(&self) -> Option<Instant> {
        let events = [
            self.script.next_event(self.now),
            self.camera.next_event(self.now),
            self.cutoff.next_event(self.now, &self.parameters),
            self.battery.flat_at(self.now, self.draw(), self.generation),
            self.tank.empty_at(self.now, self.flow()),
            self.spin.unrecoverable_at(self.now),
            self.bus.trips_at(),
            self.propulsion.trips_at(),
        ];
        events.into_iter().flatten().min()
    }

    fn pass_until(&mut self, at: Instant) {
        let time = at.since(self.now);
        self.battery.pass(time, self.draw(), self.generation);
        self.tank.pass(time, self.flow());
        self.spin.pass(time);
        self.now = at;
    }

    fn check_laws(&mut self) {
        let has_tripped = |supply: &Supply| supply.trips_at().is_some_and(|at| at <= self.now);
        let law = if has_tripped(&self.bus) {
            Law::BusTripped { draw: self.draw(), supply: self.supply() }
        } else if has_tripped(&self.propulsion) {
            let supply = self.parameters.propulsion_supply;
            Law::PropulsionTripped { draw: self.propulsion_draw(), supply }
        } else if self.spin.is_unrecoverable() {
            Law::SpunUp { rate_urad_s: self.spin.rate_urad_s() }
        } else {
            return;
        };
        self.broken = Some((self.now, law));
    }

    /// What happens by itself at this instant.
    fn happen(&mut self) {
        self.camera.happen(self.now, &self.parameters);
        self.cutoff.happen(self.now, &self.parameters);
        for fault in self.script.iter().filter(|fault| fault.happens_at() == Some(self.now)) {
            match fault {
                Fault::ThrusterSticksOpen { .. } => self.thruster.stick_open(),
                Fault::CameraUpset { .. } => self.camera.upset(),
                Fault::GenerationFalls { to, .. } => self.generation = to,
                _ => {}
            }
        }
        self.see();
    }

    /// Everybody sees how things stand from now on.
    fn see(&mut self) {
        self.battery.see(self.draw(), self.generation);
        self.bus.see(self.now, self.draw(), self.supply());
        self.propulsion.see(self.now, self.propulsion_draw(), self.parameters.propulsion_supply);
        self.spin.see(self.pushes(), &self.parameters);
        for device in DeviceId::ALL {
            let on = self.is_on(device);
            self.sensors.switches[device.index()].push(self.now, on);
        }
        self.sensors.cutoff_shut.push(self.now, self.cutoff.is_shut());
        self.sensors.exposures.push(self.now, self.camera.exposures_finished);
        self.sensors.spin.push(self.now, self.spin);
    }

    /// Whether the device's power switch is closed.
    fn is_on(&self, device: DeviceId) -> bool {
        match device {
            DeviceId::Camera => self.camera.is_on(),
            DeviceId::Thruster => self.thruster.is_on(),
            DeviceId::Cutoff => self.cutoff.is_on(),
            DeviceId::Heaters => self.heaters.is_on(),
        }
    }

    fn propulsion_draw(&self) -> Milliwatts {
        self.thruster.draw().saturating_add(self.heaters.draw())
    }

    fn draw(&self) -> Milliwatts {
        [self.camera.draw(self.now), self.cutoff.draw(), self.propulsion_draw()]
            .into_iter()
            .fold(self.parameters.base_load, Milliwatts::saturating_add)
    }

    fn supply(&self) -> Milliwatts {
        let battery = if self.battery.is_flat() {
            Milliwatts::ZERO
        } else {
            self.parameters.battery_output_max
        };
        self.generation.saturating_add(battery)
    }

    fn pushes(&self) -> bool {
        self.thruster.is_open() && !self.cutoff.is_shut() && !self.tank.is_empty()
    }

    fn flow(&self) -> MilligramsPerSecond {
        if self.pushes() { THRUSTER_FLOW } else { MilligramsPerSecond::ZERO }
    }

    /// A driver received a command.
    pub(crate) fn begin(
        &mut self,
        now: Instant,
        command: Command,
        safing: bool,
        by: Cow<'static, str>,
    ) -> Begun {
        let nth = &mut self.received[command.device().index()];
        *nth += 1;
        let failing = self.script.failing(command.device(), *nth);
        let shortest = COMMAND_TIME_MAX.as_micros() / 4;
        let time = Duration::from_micros(
            shortest + self.dice.below(COMMAND_TIME_MAX.as_micros() - shortest + 1),
        );
        let hung = match failing {
            Some(Failing::Hangs { lasting }) => lasting,
            _ => Duration::ZERO,
        };
        let outcome = Outcome::InProgress;
        self.trace.push(ReceivedCommand { begun: now, done: None, command, safing, by, outcome });
        Begun { entry: self.trace.len() - 1, time: time.saturating_add(hung), failing }
    }

    /// The command reaches its device.
    pub(crate) fn arrive(&mut self, now: Instant, entry: usize) {
        self.advance_to(now);
        let outcome = if self.broken.is_some() {
            Outcome::TooLate
        } else {
            match self.react(self.trace[entry].command) {
                Reaction::Took => Outcome::Took,
                Reaction::NoEffect => Outcome::NoEffect,
            }
        };
        self.end(now, entry, outcome);
    }

    /// The command is over.
    pub(crate) fn end(&mut self, now: Instant, entry: usize, outcome: Outcome) {
        let received = &mut self.trace[entry];
        received.done = Some(now);
        received.outcome = outcome;
    }

    fn react(&mut self, command: Command) -> Reaction {
        let reaction = match command {
            Command::Camera(crate::CameraCommand::Off) if self.camera_ignores_off() => {
                Reaction::NoEffect
            }
            Command::Camera(command) => self.camera.react(command, self.now, &self.parameters),
            Command::Thruster(command) => self.thruster.react(command),
            Command::Cutoff(command) => self.cutoff.react(command, self.now),
            Command::Heaters(command) => self.heaters.react(command),
        };
        self.see();
        reaction
    }

    fn camera_ignores_off(&mut self) -> bool {
        let ignores = self.camera.is_on() && self.offs_ignored < self.script.ignored_offs(self.now);
        self.offs_ignored += u32::from(ignores);
        ignores
    }

    pub(crate) fn estimate(&self, device: DeviceId, now: Instant) -> Option<Estimate> {
        let i = device.index();
        self.sensors.of_device[i].estimate(device, &self.sensors.switches[i], &self.script, now)
    }

    pub(crate) fn measured_rate_urad_s(&self, now: Instant) -> Option<Measured<u64>> {
        let (spin, since) = self.sensors.of_body.measured_since(&self.sensors.spin, now)?;
        let value = spin.value.later(spin.measured_at.since(since)).rate_urad_s();
        Some(Measured { value, measured_at: spin.measured_at })
    }

    pub(crate) fn measured_cutoff_shut(&self, now: Instant) -> Option<Measured<bool>> {
        self.sensors.of_device[DeviceId::Cutoff.index()].measured(&self.sensors.cutoff_shut, now)
    }

    pub(crate) fn measured_exposures(&self, now: Instant) -> Option<Measured<u32>> {
        self.sensors.of_device[DeviceId::Camera.index()].measured(&self.sensors.exposures, now)
    }

    pub(crate) fn broken_law(&self) -> Option<(Instant, Law)> {
        self.broken
    }

    pub(crate) fn trace(&self) -> &[ReceivedCommand] {
        &self.trace
    }

    pub(crate) fn truth(&self) -> Truth {
        Truth {
            at: self.now,
            supply: self.supply(),
            draw: self.draw(),
            stored_nj: self.battery.stored_nj(),
            camera_on: self.camera.is_on(),
            exposures_finished: self.camera.exposures_finished,
            exposures_lost: self.camera.exposures_lost,
            exposures_late: self.camera.exposures_late,
            thruster_open: self.thruster.is_open(),
            cutoff_shut: self.cutoff.is_shut(),
            cutoff_coil_on: self.cutoff.is_on(),
            heaters_on: self.heaters.is_on(),
            rate_urad_s: self.spin.rate_urad_s(),
            propellant_ng: self.tank.left_ng(),
        }
    }
}

impl Sensors {
    fn new(seed: u64, parameters: &Parameters) -> Self {
        Self {
            of_device: [0, 1, 2, 3].map(|number| Sensor::new(number, seed, parameters)),
            of_body: Sensor::new(4, seed, parameters),
            switches: [(); 4].map(|()| History::new(false)),
            cutoff_shut: History::new(false),
            exposures: History::new(0),
            spin: History::new(Spin::new(parameters)),
        }
    }
}
