//! The ways to the devices: drivers for gates, and bare switches for designs
//! that have none.

use std::borrow::Cow;
use std::error::Error;
use std::fmt;
use std::marker::PhantomData;
use std::panic::resume_unwind;
use std::sync::Arc;

use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Declaration, Device, Profile};

use crate::camera::Camera;
use crate::cutoff::Cutoff;
use crate::device::{Command, DeviceId, Kind};
use crate::faults::Failing;
use crate::heaters::Heaters;
use crate::interleave;
use crate::spacecraft::Shared;
use crate::thruster::Thruster;
use crate::trace::Outcome;

/// The driver of the camera's power and exposures.
pub type CameraDriver = Driver<Camera>;
/// The driver of the thruster valve.
pub type ThrusterDriver = Driver<Thruster>;
/// The driver of the cutoff valve.
pub type CutoffDriver = Driver<Cutoff>;
/// The driver of the catalyst bed heaters.
pub type HeatersDriver = Driver<Heaters>;

/// The camera without a gate.
pub type BareCamera = Bare<Camera>;
/// The thruster valve without a gate.
pub type BareThruster = Bare<Thruster>;
/// The cutoff valve without a gate.
pub type BareCutoff = Bare<Cutoff>;
/// The catalyst bed heaters without a gate.
pub type BareHeaters = Bare<Heaters>;

/// A driver: the handle to its device that goes into a gate. There is one, and
/// it cannot be copied.
pub struct Driver<K: Kind> {
    line: Line,
    profile: Profile,
    kind: PhantomData<K>,
}

impl<K: Kind> Driver<K> {
    pub(crate) fn new(shared: Arc<Shared>) -> Self {
        let profile = K::profile(&shared.plant.lock().parameters);
        Self { line: Line(shared), profile, kind: PhantomData }
    }
}

impl<K: Kind> Device for Driver<K> {
    type Command = K::Command;
    type Response = ();
    type Fault = DriverFault;

    fn profile(&self) -> Profile {
        self.profile
    }

    fn declare(command: &K::Command) -> Declaration {
        K::declare(command)
    }

    fn issue(&mut self, command: K::Command) -> Result<(), DriverFault> {
        self.line.give(command.into(), false)
    }

    fn safe(&mut self) -> Result<(), DriverFault> {
        self.line.give(K::SAFING.into(), true)
    }
}

/// A switch that anybody may have: the same hardware, without a gate. It is what
/// the designs without tickets command.
pub struct Bare<K: Kind> {
    line: Line,
    kind: PhantomData<K>,
}

impl<K: Kind> Bare<K> {
    pub(crate) fn new(shared: Arc<Shared>) -> Self {
        Self { line: Line(shared), kind: PhantomData }
    }

    /// Gives the command to the hardware.
    ///
    /// # Errors
    /// [`DriverFault`], when the script says so.
    pub fn issue(&self, command: K::Command) -> Result<(), DriverFault> {
        self.line.give(command.into(), false)
    }
}

impl<K: Kind> Clone for Bare<K> {
    fn clone(&self) -> Self {
        Self { line: self.line.clone(), kind: PhantomData }
    }
}

impl<K: Kind> fmt::Debug for Driver<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Driver({})", K::SAFING.into().device())
    }
}

impl<K: Kind> fmt::Debug for Bare<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Bare({})", K::SAFING.into().device())
    }
}

/// The driver could not do its work: the hardware did not take the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DriverFault {
    /// Whose driver.
    pub device: DeviceId,
}

impl fmt::Display for DriverFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the {} did not take the command", self.device)
    }
}

impl Error for DriverFault {}

/// The wires to the devices.
#[derive(Clone)]
struct Line(Arc<Shared>);

impl Line {
    /// Sends a command. It takes effect at its end, when it has been on its way
    /// for its time; others run meanwhile.
    fn give(&self, command: Command, safing: bool) -> Result<(), DriverFault> {
        let Shared { clock, plant, .. } = &*self.0;
        interleave::switch_point("command begins");
        let begun = plant.lock().begin(clock.now(), command, safing, caller());
        clock.wait_until(clock.now().after(begun.time));
        let answer = match begun.failing {
            None | Some(Failing::Hangs { .. }) => {
                plant.lock().arrive(clock.now(), begun.entry);
                Ok(())
            }
            Some(failing) => {
                plant.lock().end(clock.now(), begun.entry, Outcome::DriverFailed);
                Err(failing)
            }
        };
        interleave::switch_point("command ends");
        answer.map_err(|failing| fail(failing, command.device()))
    }
}

/// Fails in this way.
fn fail(failing: Failing, device: DeviceId) -> DriverFault {
    if failing == Failing::Panics {
        // Past the panic hook: this one is in the script.
        resume_unwind(Box::new(format!("the driver of the {device} panics, as scripted")));
    }
    DriverFault { device }
}

/// Who calls: a body of the interleaver, or a thread.
fn caller() -> Cow<'static, str> {
    let thread = || std::thread::current().name().unwrap_or("unnamed thread").to_owned();
    interleave::name().map_or_else(|| thread().into(), Cow::Borrowed)
}
