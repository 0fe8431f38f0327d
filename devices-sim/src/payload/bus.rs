//! The bus and what hangs on it: from event to event, exactly.

use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Duration, Instant};

use super::battery::BatteryModel;
use super::spec::UnitSpec;
use super::unit::{Unit, UnitCommand};
use crate::battery::Battery;
use crate::law::Law;
use crate::parameters::{COMMAND_TIME_MAX, Parameters};
use crate::power::Supply;
use crate::random::Dice;
use crate::sensors::{History, Measured, Sensor};
use crate::trace::Outcome;

/// What feeds a payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Supplies {
    /// What the bus can give.
    pub limit: Milliwatts,
    /// How long it bears more.
    pub trip_time: Duration,
    /// The battery behind it, if there is one. Flat, it leaves what charges it.
    pub battery: Option<BatteryModel>,
}

impl Supplies {
    /// A bus of this limit, that bears more for five milliseconds: longer than
    /// a relay bounces, shorter than anybody can react.
    #[must_use]
    pub const fn of(limit: Milliwatts) -> Self {
        Self { limit, trip_time: Duration::from_millis(5), battery: None }
    }
}

/// What the checkers of a simulation see, and software under test never does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PayloadTruth {
    /// The instant of all this; that of the loss, once the bus has tripped.
    pub at: Instant,
    /// What the bus can give.
    pub supply: Milliwatts,
    /// What is drawn from it.
    pub draw: Milliwatts,
    /// The most that ever was, for however short.
    pub largest_draw: Milliwatts,
    /// What was taken from the bus since the start.
    pub energy: Microjoules,
    /// Its units, in their order.
    pub units: Vec<UnitTruth>,
}

/// How a unit really stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitTruth {
    /// Its name.
    pub name: String,
    /// Whether its switch is closed.
    pub on: bool,
    /// What it draws.
    pub draw: Milliwatts,
    /// What it finished: images, acquisitions, turns, kibibytes.
    pub finished: u64,
    /// What it lost, because it went off, or sent it while nobody heard.
    pub lost: u64,
}

/// A command that a driver received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitCommandReceived {
    /// When its driver was called.
    pub begun: Instant,
    /// When it reached the unit.
    pub done: Option<Instant>,
    /// Which unit, by its place in the list.
    pub unit: usize,
    /// Which command.
    pub command: UnitCommand,
    /// Whether the driver was asked to make its device safe.
    pub safing: bool,
    /// What became of it.
    pub outcome: Outcome,
}

#[derive(Debug)]
pub(crate) struct Bus {
    now: Instant,
    limit: Milliwatts,
    generation: Milliwatts,
    units: Vec<Hanging>,
    other: Milliwatts,
    supply: Supply,
    battery: Option<(Battery, u64)>,
    energy_nj: u64,
    largest_draw: Milliwatts,
    broken: Option<(Instant, Law)>,
    dice: Dice,
    trace: Vec<UnitCommandReceived>,
}

/// A unit with the sensor that looks at its switch.
#[derive(Debug)]
struct Hanging {
    name: String,
    unit: Box<dyn Unit>,
    sensor: Sensor,
    switch: History<bool>,
}

impl Bus {
    pub(crate) fn new(supplies: Supplies, specs: &[UnitSpec], seed: u64, now: Instant) -> Self {
        let units = (0..).zip(specs).map(|(number, spec)| Hanging::new(number, seed, spec));
        Self {
            now,
            limit: supplies.limit,
            generation: supplies.battery.map_or(Milliwatts::ZERO, |battery| battery.generation),
            units: units.collect(),
            other: Milliwatts::ZERO,
            supply: Supply::new(supplies.trip_time),
            battery: supplies.battery.map(battery),
            energy_nj: 0,
            largest_draw: Milliwatts::ZERO,
            broken: None,
            dice: Dice::new(seed, 0),
            trace: Vec::new(),
        }
    }

    /// Lets the physics catch up with the clock. Nothing happens after a loss.
    pub(crate) fn advance_to(&mut self, target: Instant) {
        while self.broken.is_none() && self.now < target {
            let next = self.next_event().filter(|at| *at <= target);
            self.pass_until(next.unwrap_or(target));
            if self.supply.trips_at().is_some_and(|at| at <= self.now) {
                let law = Law::BusTripped { draw: self.draw(), supply: self.gives() };
                self.broken = Some((self.now, law));
            } else if next.is_some() {
                self.units.iter_mut().for_each(|hanging| hanging.unit.happen(self.now));
                self.see();
            }
        }
    }

    fn next_event(&self) -> Option<Instant> {
        let of_units = self.units.iter().filter_map(|hanging| hanging.unit.next_event(self.now));
        let flat = self
            .battery
            .as_ref()
            .and_then(|(battery, _)| battery.flat_at(self.now, self.draw(), self.generation));
        of_units.chain(flat).chain(self.supply.trips_at()).min()
    }

    fn pass_until(&mut self, at: Instant) {
        let (time, draw) = (at.since(self.now), self.draw());
        self.energy_nj = self.energy_nj.saturating_add(draw.get().saturating_mul(time.as_micros()));
        if let Some((battery, _)) = &mut self.battery {
            battery.pass(time, draw, self.generation);
        }
        self.now = at;
    }

    /// Everybody sees how things stand from now on.
    fn see(&mut self) {
        let draw = self.draw();
        self.largest_draw = self.largest_draw.max(draw);
        if let Some((battery, _)) = &mut self.battery {
            battery.see(draw, self.generation);
        }
        let gives = self.gives();
        self.supply.see(self.now, draw, gives);
        for hanging in &mut self.units {
            hanging.switch.push(self.now, hanging.unit.is_on());
        }
    }

    fn draw(&self) -> Milliwatts {
        let draws = self.units.iter().map(|hanging| hanging.unit.draw(self.now));
        draws.fold(self.other, Milliwatts::saturating_add)
    }

    fn gives(&self) -> Milliwatts {
        let flat = self.battery.as_ref().is_some_and(|(battery, _)| battery.is_flat());
        if flat { self.limit.min(self.generation) } else { self.limit }
    }

    pub(crate) fn set_other_draw(&mut self, now: Instant, draw: Milliwatts) {
        self.advance_to(now);
        self.other = draw;
        self.see();
    }

    /// A driver received a command: its place in the trace, and how long it
    /// takes.
    pub(crate) fn begin(
        &mut self,
        now: Instant,
        unit: usize,
        command: UnitCommand,
        safing: bool,
    ) -> (usize, Duration) {
        let longest = COMMAND_TIME_MAX.as_micros();
        let time = longest / 4 + self.dice.below(longest - longest / 4 + 1);
        let outcome = Outcome::InProgress;
        let received =
            UnitCommandReceived { begun: now, done: None, unit, command, safing, outcome };
        self.trace.push(received);
        (self.trace.len() - 1, Duration::from_micros(time))
    }

    /// The command reaches its unit. Whether the bus has power.
    pub(crate) fn arrive(&mut self, now: Instant, entry: usize) -> bool {
        self.advance_to(now);
        let UnitCommandReceived { unit, command, .. } = self.trace[entry];
        let outcome = if self.broken.is_some() {
            Outcome::TooLate
        } else if self.units[unit].unit.react(command.action, now) {
            Outcome::Took
        } else {
            Outcome::NoEffect
        };
        self.see();
        self.trace[entry].done = Some(now);
        self.trace[entry].outcome = outcome;
        outcome != Outcome::TooLate
    }

    pub(crate) fn switch(&self, unit: usize, now: Instant) -> Option<Measured<bool>> {
        let hanging = self.units.get(unit)?;
        hanging.sensor.measured(&hanging.switch, now)
    }

    pub(crate) fn state_of_charge(&self) -> Option<u8> {
        let (battery, capacity_nj) = self.battery.as_ref()?;
        let percent = u128::from(battery.stored_nj()) * 100 / u128::from((*capacity_nj).max(1));
        u8::try_from(percent).ok()
    }

    pub(crate) fn broken_law(&self) -> Option<(Instant, Law)> {
        self.broken
    }

    pub(crate) fn trace(&self) -> &[UnitCommandReceived] {
        &self.trace
    }

    pub(crate) fn truth(&self) -> PayloadTruth {
        PayloadTruth {
            at: self.now,
            supply: self.gives(),
            draw: self.draw(),
            largest_draw: self.largest_draw,
            energy: Microjoules::new(self.energy_nj / 1_000),
            units: self.units.iter().map(|hanging| hanging.truth(self.now)).collect(),
        }
    }
}

impl Hanging {
    fn new(number: u64, seed: u64, spec: &UnitSpec) -> Self {
        let rhythm = Parameters {
            sensor_period: spec.sensor_period,
            sensor_lag: spec.sensor_lag,
            sensor_unknown_permille: 0,
            ..Parameters::default()
        };
        let sensor = Sensor::new(number, seed, &rhythm);
        Self { name: spec.name.clone(), unit: spec.make(), sensor, switch: History::new(false) }
    }

    fn truth(&self, now: Instant) -> UnitTruth {
        let made = self.unit.made(now);
        UnitTruth {
            name: self.name.clone(),
            on: self.unit.is_on(),
            draw: self.unit.draw(now),
            finished: made.finished,
            lost: made.lost,
        }
    }
}

fn battery(model: BatteryModel) -> (Battery, u64) {
    let parameters = Parameters {
        battery_capacity: model.capacity,
        battery_stored: model.stored,
        ..Parameters::default()
    };
    (Battery::new(&parameters), model.capacity.get().saturating_mul(1_000))
}
