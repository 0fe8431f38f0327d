//! The numbers of the spacecraft, with their reasons.
//!
//! They make the emergency real. Base load and camera fit the supply; base load
//! and cutoff coil fit; all three together trip the bus, and so do base load,
//! coil and heaters. A thruster that sticks open leaves 1.5 s, of which turning
//! the camera off, three times and confirmed each time, and shutting the cutoff
//! valve take about 0.2 s.

use faregate_tickets::amount::{Microjoules, Milligrams, MilligramsPerSecond, Milliwatts};
use faregate_tickets::clock::{Duration, Instant};

/// Camera, steady: a detector, its cooler and its electronics.
pub const CAMERA_DRAW: Milliwatts = Milliwatts::from_watts(30);
/// Camera, while its converters charge.
pub const CAMERA_INRUSH: Milliwatts = Milliwatts::from_watts(34);
/// Cutoff valve, while its coil is driven: a latching valve takes much, once.
pub const CUTOFF_DRAW: Milliwatts = Milliwatts::from_watts(45);
/// Thruster valve, while its solenoid is held open.
pub const THRUSTER_DRAW: Milliwatts = Milliwatts::from_watts(8);
/// 1 N at a specific impulse of 220 s: 1 / (220 * 9.81) kg/s.
pub const THRUSTER_FLOW: MilligramsPerSecond = MilligramsPerSecond::new(463);
/// Catalyst bed heaters, all of them.
pub const HEATERS_DRAW: Milliwatts = Milliwatts::from_watts(12);
/// The longest time of any command: one transaction on the bus. Commands take
/// between a quarter of it and all of it, as the seed wants.
pub const COMMAND_TIME_MAX: Duration = Duration::from_millis(1);

/// What can differ between one simulated spacecraft and another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameters {
    /// What is always on: computer, radio, attitude sensors.
    pub base_load: Milliwatts,
    /// Output of the radioisotope generator.
    pub generation: Milliwatts,
    /// What the battery can add to it while it is not flat. Together they are
    /// the supply: 125 W.
    pub battery_output_max: Milliwatts,
    /// What the battery holds: 20 Wh.
    pub battery_capacity: Microjoules,
    /// What is in it at the start.
    pub battery_stored: Microjoules,
    /// How long the bus bears a draw above the supply. Longer than a relay
    /// bounces, shorter than anybody can react.
    pub bus_trip_time: Duration,
    /// What the propulsion converter can give to heaters and thruster valve:
    /// either, not both.
    pub propulsion_supply: Milliwatts,
    /// How long it bears more.
    pub propulsion_trip_time: Duration,
    /// How long the camera's inrush lasts.
    pub camera_inrush_time: Duration,
    /// How long the camera still draws after its switch opened. Twice the trip
    /// time: whoever trusts the switch trips the bus.
    pub camera_settling: Duration,
    /// How long an exposure takes.
    pub exposure_time: Duration,
    /// An exposure that ends later shows nothing of interest.
    pub exposure_deadline: Instant,
    /// How long the cutoff coil must be driven until the valve is shut.
    pub cutoff_pull_in: Duration,
    /// How long the valve's electronics drive the coil, if nobody ends it.
    pub cutoff_pulse: Duration,
    /// 1 N at a lever of 1 m, in micronewton metres.
    pub thruster_torque_unm: u32,
    /// Moment of inertia, in kilogram square metres: a small probe. With the
    /// torque above the rate grows by 0.1 rad/s in a second.
    pub inertia_kgm2: u32,
    /// The rate from which the wheels cannot bring it back, in microradians per
    /// second: 8.6 degrees per second.
    pub unrecoverable_rate_urad_s: u32,
    /// Propellant at the start: 5 kg.
    pub propellant: Milligrams,
    /// How often each sensor measures.
    pub sensor_period: Duration,
    /// From the measurement until the estimate arrives.
    pub sensor_lag: Duration,
    /// How many of a thousand measurements say nothing.
    pub sensor_unknown_permille: u16,
    /// A command that takes so many times its declared time has overrun. In
    /// virtual time none does by itself; a busy host makes threads oversleep.
    pub overrun_factor: u8,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            base_load: Milliwatts::from_watts(70),
            generation: Milliwatts::from_watts(100),
            battery_output_max: Milliwatts::from_watts(25),
            battery_capacity: Microjoules::from_joules(72_000),
            battery_stored: Microjoules::from_joules(60_000),
            bus_trip_time: Duration::from_millis(5),
            propulsion_supply: Milliwatts::from_watts(15),
            propulsion_trip_time: Duration::from_millis(5),
            camera_inrush_time: Duration::from_millis(5),
            camera_settling: Duration::from_millis(10),
            exposure_time: Duration::from_millis(400),
            exposure_deadline: Instant::from_micros(5_000_000),
            cutoff_pull_in: Duration::from_millis(40),
            cutoff_pulse: Duration::from_millis(60),
            thruster_torque_unm: 1_000_000,
            inertia_kgm2: 10,
            unrecoverable_rate_urad_s: 150_000,
            propellant: Milligrams::new(5_000_000),
            sensor_period: Duration::from_millis(5),
            sensor_lag: Duration::from_millis(20),
            sensor_unknown_permille: 20,
            overrun_factor: 4,
        }
    }
}

impl Parameters {
    /// The supply while the battery is not flat: what a power margin is
    /// counted from.
    #[must_use]
    pub fn supply(&self) -> Milliwatts {
        self.generation.saturating_add(self.battery_output_max)
    }
}
