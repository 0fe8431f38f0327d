//! The floor of an emergency: the same commands without gates, and the two
//! wake-ups that nothing can spare. The sensors' thread has to hear that there
//! is something to see, and the rescuer that it was seen.

use std::time::{Duration, Instant};

use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::wake::{Wakeup, Woken};
use faregate_tickets::Device;
use faregate_tickets::clock::{Clock, Duration as Timeout};
use faregate_tickets::id::GateId;

use crate::plant::{Plant, Switch, patient};
use crate::roles::Role;
use crate::support::Failure;

/// A camera, a cutoff valve, and a thread that sees whether the camera is off.
pub(crate) struct Floor {
    plant: &'static Plant,
    camera: Switch,
    cutoff: Switch,
    seen: &'static Wakeup,
}

impl Floor {
    pub(crate) fn new() -> std::io::Result<Self> {
        let plant: &'static Plant = Box::leak(Box::new(Plant::new()?));
        let seen: &'static Wakeup = Box::leak(Box::new(Wakeup::new()?));
        let switch = |gate| Switch { plant, gate: GateId(gate), profile: patient() };
        Role::Sensors.start("floor-sensors", move || {
            while plant.sensors.wait_until(None).is_ok() {
                for camera in plant.take_safed() {
                    if !plant.is_on(camera) {
                        seen.notify();
                    }
                }
            }
        })?;
        Ok(Self { plant, camera: switch(0), cutoff: switch(1), seen })
    }

    /// From the decision to make the camera safe until the cutoff is commanded.
    pub(crate) fn round(&mut self) -> Result<Duration, Failure> {
        let fault = |()| "a simulated driver does not fail";
        self.camera.issue(true).map_err(fault)?;
        self.cutoff.issue(false).map_err(fault)?;
        let start = Instant::now();
        self.camera.safe().map_err(fault)?;
        let deadline = MonotonicClock::new().now().after(Timeout::from_secs(5));
        let woken = self.seen.wait_until(Some(deadline))?;
        self.cutoff.issue(true).map_err(fault)?;
        let took = start.elapsed();
        let truth = (woken, self.plant.is_on(GateId(0)), self.plant.is_on(GateId(1)));
        if truth != (Woken::Notified, false, true) {
            return Err(format!("the floor did not hold: {truth:?}").into());
        }
        Ok(took)
    }
}
