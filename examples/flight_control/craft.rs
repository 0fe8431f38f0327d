//! The spacecraft of this flight, and its broker.

use std::convert::Infallible;

use faregate::prelude::*;
use faregate::tickets::interlock::{Interlock, Side};
use faregate_devices_sim::{
    CameraDriver, CutoffDriver, DeviceId, Fault, FaultScript, HeatersDriver, SimClock, Spacecraft,
    ThrusterDriver,
};

use crate::support::{self, Outcome, Sensors};

/// When the thruster valve sticks open.
pub(crate) const STICKS_AT: Instant = Instant::START.after(Duration::from_millis(1_200));

/// Above all holders.
const SERVICE_FIFO: u8 = 80;

/// Thruster valve and heaters share a converter that cannot feed both.
static INTERLOCK: Interlock = Interlock::new();

/// What all threads have in common.
pub(crate) struct Craft {
    pub(crate) spacecraft: Spacecraft,
    pub(crate) broker: Broker,
    pub(crate) wheel: Handle<Wheel>,
    pub(crate) valve: Handle<ThrusterDriver>,
    pub(crate) heaters: Handle<HeatersDriver>,
    pub(crate) camera: Handle<CameraDriver>,
    pub(crate) cutoff: Handle<CutoffDriver>,
    _sensors: Sensors,
}

impl Craft {
    /// Camera, heaters and thruster valve fit the supply together. With the
    /// cutoff valve's coil, only the thruster valve does.
    pub(crate) fn new() -> Outcome<Self> {
        let parameters = support::parameters();
        let margin = parameters.supply().saturating_sub(parameters.base_load);
        let script = FaultScript::new().with(Fault::ThrusterSticksOpen { at: STICKS_AT });
        let spacecraft = Spacecraft::new(parameters, script, 1, &SimClock::real_time());
        let taken = "the driver is taken";

        let mut builder = Broker::builder()?;
        let power = builder.agent(Policy::power_margin(margin))?;
        let attitude = builder.agent(Policy::exclusive())?;
        let side_a = GateOptions::new().interlocked(INTERLOCK.member(Side::A, 0)?);
        let side_b = GateOptions::new().interlocked(INTERLOCK.member(Side::B, 0)?);
        let driver = spacecraft.thruster_driver().ok_or(taken)?;
        let valve = builder.gate_with(power, "thruster valve", driver, side_a)?;
        let driver = spacecraft.heaters_driver().ok_or(taken)?;
        let heaters = builder.gate_with(power, "heaters", driver, side_b)?;
        let camera = builder.gate(power, "camera", spacecraft.camera_driver().ok_or(taken)?)?;
        let cutoff =
            builder.gate(power, "cutoff valve", spacecraft.cutoff_driver().ok_or(taken)?)?;
        let wheel = builder.gate(attitude, "wheel", Wheel { torque_unm: 0 })?;
        let broker = builder.real_time(SERVICE_FIFO).start()?;

        let gates = [
            (valve.gate(), DeviceId::Thruster),
            (heaters.gate(), DeviceId::Heaters),
            (camera.gate(), DeviceId::Camera),
            (cutoff.gate(), DeviceId::Cutoff),
        ];
        let sensors = Sensors::start(&broker, &spacecraft, gates)?;
        Ok(Self { spacecraft, broker, wheel, valve, heaters, camera, cutoff, _sensors: sensors })
    }
}

/// The reaction wheel's driver. Its electronics are always on, in the base
/// load: nothing is charged for it. The simulated body does not feel it.
pub(crate) struct Wheel {
    torque_unm: i64,
}

/// A torque, in micronewton metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Torque {
    pub(crate) unm: i64,
}

impl Device for Wheel {
    type Command = Torque;
    type Response = ();
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        let mut profile = Profile::new();
        profile.overrun_factor = support::parameters().overrun_factor;
        profile
    }

    fn declare(_: &Torque) -> Declaration {
        Declaration { code: 1, wcet: Duration::from_micros(100), effect: Effect::Unchanged }
    }

    fn issue(&mut self, torque: Torque) -> Result<(), Infallible> {
        self.torque_unm = torque.unm;
        Ok(())
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        self.issue(Torque { unm: 0 })
    }
}
