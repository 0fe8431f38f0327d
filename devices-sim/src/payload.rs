//! A payload: a bus that trips, a battery, and whatever units a mission has.
//!
//! [`Spacecraft`](crate::Spacecraft) is one craft with one emergency. A
//! [`Payload`] is put together from a list: so many cameras, a gimbal, a
//! transmitter with its passes, a processor whose draw depends on its load. Each
//! unit is a file here. Draws change at events and are constant between them, so
//! energy is exact and does not depend on who looks when.
//!
//! ```
//! use std::collections::BTreeMap;
//! use faregate_devices_sim::SimClock;
//! use faregate_devices_sim::payload::{Payload, Supplies, UnitSpec};
//! use faregate_tickets::Device;
//! use faregate_tickets::amount::Milliwatts;
//! use faregate_tickets::clock::{Clock, Duration};
//!
//! let spec = UnitSpec::new("imager", "camera", None, &BTreeMap::new()).expect("a camera");
//! let clock = SimClock::virtual_time();
//! let supplies = Supplies::of(Milliwatts::from_watts(42));
//! let payload = Payload::new(supplies, vec![spec], 7, &clock);
//! let mut camera = payload.driver("imager").expect("nobody took it before");
//! let on = camera.parse("on", &[])?;
//! camera.issue(on).map_err(|fault| fault.to_string())?;
//! assert_eq!(payload.truth().draw, camera.profile().draw, "the inrush is what is declared");
//! clock.advance_to(clock.now().after(Duration::from_secs(1)));
//! assert!(payload.truth().draw < camera.profile().draw);
//! # Ok::<(), String>(())
//! ```

mod battery;
mod bus;
mod camera;
mod computer;
mod driver;
mod gimbal;
mod heater;
mod processor;
mod radio;
mod settings;
mod spec;
mod transmitter;
mod unit;

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Instant};
use faregate_tickets::device::{Estimate, Power};
use parking_lot::Mutex;

pub use battery::BatteryModel;
pub use bus::{PayloadTruth, Supplies, UnitCommandReceived, UnitTruth};
pub use driver::{UnitDriver, UnitFault, UnitWords};
pub use spec::{KINDS, UnitSpec};
pub use unit::{CommandHelp, UnitCommand};

use crate::clock::SimClock;
use crate::law::Law;
use crate::sensors::Measured;
use bus::Bus;

/// A simulated payload; clones are the same one.
///
/// Its physics follows its [clock](SimClock). Software under test sees
/// estimates and measured values; [`truth`](Self::truth), and what follows it,
/// are for checkers.
#[derive(Clone)]
pub struct Payload(Arc<Shared>);

/// What payload and drivers share. The lock is never held while anybody waits.
pub(crate) struct Shared {
    pub(crate) clock: SimClock,
    pub(crate) bus: Mutex<Bus>,
    specs: Vec<UnitSpec>,
    /// One for each driver that was taken. Only its own value matters: Relaxed.
    taken: Vec<AtomicBool>,
}

impl Payload {
    /// A payload of these units, all off. The seed decides how long commands
    /// take and when sensors measure.
    #[must_use]
    pub fn new(supplies: Supplies, specs: Vec<UnitSpec>, seed: u64, clock: &SimClock) -> Self {
        let bus = Mutex::new(Bus::new(supplies, &specs, seed, clock.now()));
        let taken = specs.iter().map(|_| AtomicBool::new(false)).collect();
        Self(Arc::new(Shared { clock: clock.clone(), bus, specs, taken }))
    }

    /// Its clock.
    #[must_use]
    pub fn clock(&self) -> &SimClock {
        &self.0.clock
    }

    /// The names of its units.
    pub fn units(&self) -> impl Iterator<Item = &str> {
        self.0.specs.iter().map(|spec| spec.name.as_str())
    }

    /// The driver of a unit; none if there is no such unit, or it was taken
    /// before.
    #[must_use]
    pub fn driver(&self, name: &str) -> Option<UnitDriver> {
        let index = self.index(name)?;
        let taken = self.0.taken.get(index)?.swap(true, Ordering::Relaxed);
        (!taken).then(|| UnitDriver::new(Arc::clone(&self.0), index))
    }

    /// What the sensors say about a unit's power switch; nothing before the
    /// first measurement has arrived.
    #[must_use]
    pub fn estimate(&self, name: &str) -> Option<Estimate> {
        let index = self.index(name)?;
        let Measured { value, measured_at } = self.looked_at(|bus, now| bus.switch(index, now))?;
        Some(Estimate { state: if value { Power::On } else { Power::Off }, measured_at })
    }

    /// What the battery's gauge says, in whole percent; none without a battery.
    #[must_use]
    pub fn state_of_charge(&self) -> Option<u8> {
        self.looked_at(|bus, _| bus.state_of_charge())
    }

    /// Whatever else draws from the bus draws this much from now on: the
    /// computer that the tasks run on, say.
    pub fn set_other_draw(&self, draw: Milliwatts) {
        self.looked_at(|bus, now| bus.set_other_draw(now, draw));
    }

    /// How things really stand.
    #[must_use]
    pub fn truth(&self) -> PayloadTruth {
        self.looked_at(|bus, _| bus.truth())
    }

    /// The law that was broken, and when. Physics ends there.
    #[must_use]
    pub fn broken_law(&self) -> Option<(Instant, Law)> {
        self.looked_at(|bus, _| bus.broken_law())
    }

    /// Every command that a driver received, in the order in which they came.
    #[must_use]
    pub fn trace(&self) -> Vec<UnitCommandReceived> {
        self.looked_at(|bus, _| bus.trace().to_vec())
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.0.specs.iter().position(|spec| spec.name == name)
    }

    fn looked_at<R>(&self, look: impl FnOnce(&mut Bus, Instant) -> R) -> R {
        let mut bus = self.0.bus.lock();
        let now = self.0.clock.now();
        bus.advance_to(now);
        look(&mut bus, now)
    }
}

impl Shared {
    pub(crate) fn spec(&self, index: usize) -> &UnitSpec {
        &self.specs[index]
    }
}

impl fmt::Debug for Payload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Payload").field(&self.truth()).finish()
    }
}
