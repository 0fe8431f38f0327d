//! What the spacecraft's switchable devices have in common.

use std::fmt;

use faregate_tickets::device::{Declaration, Profile};

use crate::camera::CameraCommand;
use crate::cutoff::CutoffCommand;
use crate::heaters::HeatersCommand;
use crate::parameters::{COMMAND_TIME_MAX, Parameters};
use crate::thruster::ThrusterCommand;

/// The devices that can be commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DeviceId {
    /// The camera.
    Camera,
    /// The valve of the thruster that may stick open.
    Thruster,
    /// The valve that cuts off the propellant.
    Cutoff,
    /// The catalyst bed heaters.
    Heaters,
}

impl DeviceId {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Camera, Self::Thruster, Self::Cutoff, Self::Heaters];

    pub(crate) const fn index(self) -> usize {
        match self {
            Self::Camera => 0,
            Self::Thruster => 1,
            Self::Cutoff => 2,
            Self::Heaters => 3,
        }
    }

    pub(crate) const fn bit(self) -> u8 {
        1 << self.index()
    }
}

impl fmt::Display for DeviceId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Camera => "camera",
            Self::Thruster => "thruster valve",
            Self::Cutoff => "cutoff valve",
            Self::Heaters => "catalyst bed heaters",
        })
    }
}

/// A command to any device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// To the camera.
    Camera(CameraCommand),
    /// To the thruster valve.
    Thruster(ThrusterCommand),
    /// To the cutoff valve.
    Cutoff(CutoffCommand),
    /// To the catalyst bed heaters.
    Heaters(HeatersCommand),
}

impl Command {
    /// The device it is for.
    #[must_use]
    pub const fn device(self) -> DeviceId {
        match self {
            Self::Camera(_) => DeviceId::Camera,
            Self::Thruster(_) => DeviceId::Thruster,
            Self::Cutoff(_) => DeviceId::Cutoff,
            Self::Heaters(_) => DeviceId::Heaters,
        }
    }
}

/// A kind of device, as a type: its command set and what is declared of it.
/// Implemented by the markers of this crate.
pub trait Kind: sealed::Sealed + Send + Sync + 'static {
    /// The command set.
    type Command: Copy + Send + Into<Command>;
    /// The command that frees its draw.
    const SAFING: Self::Command;

    /// What is declared of one command.
    fn declare(command: &Self::Command) -> Declaration;

    /// What is declared of the device, on a spacecraft with these parameters.
    fn profile(parameters: &Parameters) -> Profile;
}

pub(crate) mod sealed {
    pub trait Sealed {}
}

/// What all devices declare alike: command times, and when an estimate has
/// come: the next measurement may be a period away, and it may say nothing.
pub(crate) fn common_profile(parameters: &Parameters) -> Profile {
    let mut profile = Profile::new();
    profile.longest_command = COMMAND_TIME_MAX;
    profile.longest_safing = COMMAND_TIME_MAX;
    profile.estimate_lag =
        parameters.sensor_lag.saturating_add(parameters.sensor_period.saturating_mul(2));
    profile.overrun_factor = parameters.overrun_factor;
    profile
}
