//! The spacecraft as its software and its checkers see it.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use faregate_tickets::clock::{Clock, Instant};
use faregate_tickets::device::Estimate;
use parking_lot::Mutex;

use crate::clock::SimClock;
use crate::device::{DeviceId, Kind};
use crate::drivers::{
    Bare, BareCamera, BareCutoff, BareHeaters, BareThruster, CameraDriver, CutoffDriver, Driver,
    HeatersDriver, ThrusterDriver,
};
use crate::faults::FaultScript;
use crate::law::Law;
use crate::parameters::Parameters;
use crate::plant::{Plant, Truth};
use crate::sensors::Measured;
use crate::trace::ReceivedCommand;

/// A simulated spacecraft; clones are the same one.
///
/// Its physics follows its [clock](SimClock): it catches up whenever a command
/// arrives or somebody looks. Flight software looks through the *measured*
/// values and [`estimate`](Self::estimate); [`truth`](Self::truth) and what
/// follows it are for checkers.
#[derive(Clone)]
pub struct Spacecraft(Arc<Shared>);

/// What spacecraft and drivers share. The lock is never held while anybody
/// waits, so in virtual time it is never found locked.
pub(crate) struct Shared {
    pub(crate) clock: SimClock,
    pub(crate) plant: Mutex<Plant>,
    /// One bit per driver that was taken. Only its own value matters: Relaxed.
    taken: AtomicU8,
}

impl Spacecraft {
    /// A spacecraft on which this goes wrong. The seed decides how long commands
    /// take and when sensors measure and say nothing.
    #[must_use]
    pub fn new(parameters: Parameters, script: FaultScript, seed: u64, clock: &SimClock) -> Self {
        let plant = Mutex::new(Plant::new(parameters, script, seed));
        Self(Arc::new(Shared { clock: clock.clone(), plant, taken: AtomicU8::new(0) }))
    }

    /// Its clock.
    #[must_use]
    pub fn clock(&self) -> &SimClock {
        &self.0.clock
    }

    /// Moves the virtual clock to `instant`, and the physics with it. For use
    /// outside an interleaver, which moves its clock itself.
    pub fn advance_to(&self, instant: Instant) {
        self.0.clock.advance_to(instant);
        self.looked_at(|_, _| ());
    }

    /// The camera's driver; none if it was taken before.
    #[must_use]
    pub fn camera_driver(&self) -> Option<CameraDriver> {
        self.take(DeviceId::Camera)
    }

    /// The thruster valve's driver; none if it was taken before.
    #[must_use]
    pub fn thruster_driver(&self) -> Option<ThrusterDriver> {
        self.take(DeviceId::Thruster)
    }

    /// The cutoff valve's driver; none if it was taken before.
    #[must_use]
    pub fn cutoff_driver(&self) -> Option<CutoffDriver> {
        self.take(DeviceId::Cutoff)
    }

    /// The heaters' driver; none if it was taken before.
    #[must_use]
    pub fn heaters_driver(&self) -> Option<HeatersDriver> {
        self.take(DeviceId::Heaters)
    }

    fn take<K: Kind>(&self, device: DeviceId) -> Option<Driver<K>> {
        let taken = self.0.taken.fetch_or(device.bit(), Ordering::Relaxed);
        (taken & device.bit() == 0).then(|| Driver::new(Arc::clone(&self.0)))
    }

    /// The camera without a gate.
    #[must_use]
    pub fn bare_camera(&self) -> BareCamera {
        Bare::new(Arc::clone(&self.0))
    }

    /// The thruster valve without a gate.
    #[must_use]
    pub fn bare_thruster(&self) -> BareThruster {
        Bare::new(Arc::clone(&self.0))
    }

    /// The cutoff valve without a gate.
    #[must_use]
    pub fn bare_cutoff(&self) -> BareCutoff {
        Bare::new(Arc::clone(&self.0))
    }

    /// The heaters without a gate.
    #[must_use]
    pub fn bare_heaters(&self) -> BareHeaters {
        Bare::new(Arc::clone(&self.0))
    }

    /// What the sensors say about a device's power switch; nothing before the
    /// first measurement has arrived. A switch that is off says nothing of what
    /// the device still draws while it settles.
    #[must_use]
    pub fn estimate(&self, device: DeviceId) -> Option<Estimate> {
        self.looked_at(|plant, now| plant.estimate(device, now))
    }

    /// The body's rate, in microradians per second.
    #[must_use]
    pub fn measured_rate_urad_s(&self) -> Option<Measured<u64>> {
        self.looked_at(|plant, now| plant.measured_rate_urad_s(now))
    }

    /// Whether the cutoff valve is shut, by its position sensor.
    #[must_use]
    pub fn measured_cutoff_shut(&self) -> Option<Measured<bool>> {
        self.looked_at(|plant, now| plant.measured_cutoff_shut(now))
    }

    /// How many exposures the camera finished by their deadline.
    #[must_use]
    pub fn measured_exposures(&self) -> Option<Measured<u32>> {
        self.looked_at(|plant, now| plant.measured_exposures(now))
    }

    /// How things really stand.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.looked_at(|plant, _| plant.truth())
    }

    /// The first law that was broken, and when. Physics ends there.
    #[must_use]
    pub fn broken_law(&self) -> Option<(Instant, Law)> {
        self.looked_at(|plant, _| plant.broken_law())
    }

    /// Every command that a driver or a bare switch received, in the order in
    /// which they were called.
    #[must_use]
    pub fn trace(&self) -> Vec<ReceivedCommand> {
        self.looked_at(|plant, _| plant.trace().to_vec())
    }

    fn looked_at<R>(&self, look: impl FnOnce(&Plant, Instant) -> R) -> R {
        let mut plant = self.0.plant.lock();
        let now = self.0.clock.now();
        plant.advance_to(now);
        look(&plant, now)
    }
}

impl fmt::Debug for Spacecraft {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Spacecraft").field(&self.truth()).finish()
    }
}
