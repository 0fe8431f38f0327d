//! The camera: a switch, an inrush, exposures.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Instant;
use faregate_tickets::device::{Declaration, Effect, Profile};

use crate::device::{Command, Kind, common_profile, sealed};
use crate::parameters::{CAMERA_DRAW, CAMERA_INRUSH, COMMAND_TIME_MAX, Parameters};
use crate::plant::Reaction;

/// The camera's command set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CameraCommand {
    /// Close the power switch. When it is closed already, nothing happens.
    On,
    /// Open the power switch. The exposure in progress is lost.
    Off,
    /// Begin an exposure, if the camera is on and none is in progress.
    Expose,
}

/// The camera, as a type.
#[derive(Debug)]
pub enum Camera {}

impl sealed::Sealed for Camera {}

impl From<CameraCommand> for Command {
    fn from(command: CameraCommand) -> Self {
        Self::Camera(command)
    }
}

impl Kind for Camera {
    type Command = CameraCommand;
    const SAFING: CameraCommand = CameraCommand::Off;

    fn declare(command: &CameraCommand) -> Declaration {
        let (code, effect) = match command {
            CameraCommand::On => (1, Effect::on(CAMERA_INRUSH)),
            CameraCommand::Off => (2, Effect::Off),
            CameraCommand::Expose => (3, Effect::Unchanged),
        };
        Declaration { code, wcet: COMMAND_TIME_MAX, effect }
    }

    fn profile(parameters: &Parameters) -> Profile {
        let mut profile = common_profile(parameters).drawing(CAMERA_INRUSH);
        profile.settling = parameters.camera_settling;
        profile
    }
}

/// What the camera is and does.
#[derive(Clone, Debug)]
pub(crate) struct CameraState {
    power: CameraPower,
    exposure_ends: Option<Instant>,
    pub(crate) exposures_finished: u32,
    pub(crate) exposures_lost: u32,
    pub(crate) exposures_late: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CameraPower {
    Off,
    /// The switch is closed.
    On {
        inrush_ends: Instant,
    },
    /// The switch is open; the converters still draw.
    Settling {
        until: Instant,
    },
}

impl CameraState {
    pub(crate) fn new() -> Self {
        Self {
            power: CameraPower::Off,
            exposure_ends: None,
            exposures_finished: 0,
            exposures_lost: 0,
            exposures_late: 0,
        }
    }

    /// Whether the switch is closed: what the sensor sees.
    pub(crate) fn is_on(&self) -> bool {
        matches!(self.power, CameraPower::On { .. })
    }

    pub(crate) fn draw(&self, now: Instant) -> Milliwatts {
        match self.power {
            CameraPower::Off => Milliwatts::ZERO,
            CameraPower::On { inrush_ends } if now < inrush_ends => CAMERA_INRUSH,
            CameraPower::On { .. } | CameraPower::Settling { .. } => CAMERA_DRAW,
        }
    }

    pub(crate) fn next_event(&self, now: Instant) -> Option<Instant> {
        let power = match self.power {
            CameraPower::On { inrush_ends } => Some(inrush_ends),
            CameraPower::Settling { until } => Some(until),
            CameraPower::Off => None,
        };
        [power, self.exposure_ends].into_iter().flatten().filter(|at| *at > now).min()
    }

    pub(crate) fn happen(&mut self, now: Instant, parameters: &Parameters) {
        if matches!(self.power, CameraPower::Settling { until } if until <= now) {
            self.power = CameraPower::Off;
        }
        if self.exposure_ends.is_some_and(|at| at <= now) {
            self.exposure_ends = None;
            if now <= parameters.exposure_deadline {
                self.exposures_finished += 1;
            } else {
                self.exposures_late += 1;
            }
        }
    }

    pub(crate) fn react(
        &mut self,
        command: CameraCommand,
        now: Instant,
        parameters: &Parameters,
    ) -> Reaction {
        match command {
            CameraCommand::On if !self.is_on() => {
                self.power =
                    CameraPower::On { inrush_ends: now.after(parameters.camera_inrush_time) };
            }
            CameraCommand::Off if self.is_on() => {
                self.lose_exposure();
                self.power = CameraPower::Settling { until: now.after(parameters.camera_settling) };
            }
            CameraCommand::Expose if self.is_on() && self.exposure_ends.is_none() => {
                self.exposure_ends = Some(now.after(parameters.exposure_time));
            }
            _ => return Reaction::NoEffect,
        }
        Reaction::Took
    }

    /// An upset: the latch-up protection cuts switch and converters at once.
    pub(crate) fn upset(&mut self) {
        self.lose_exposure();
        self.power = CameraPower::Off;
    }

    fn lose_exposure(&mut self) {
        if self.exposure_ends.take().is_some() {
            self.exposures_lost += 1;
        }
    }
}
