//! The thruster valve: a spring holds it shut, a solenoid holds it open, and it
//! can stick.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::device::{Declaration, Effect, Profile};

use crate::device::{Command, Kind, common_profile, sealed};
use crate::parameters::{COMMAND_TIME_MAX, Parameters, THRUSTER_DRAW, THRUSTER_FLOW};
use crate::plant::Reaction;

/// The thruster valve's command set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ThrusterCommand {
    /// Drive the solenoid.
    Open,
    /// Let go of it.
    Close,
}

/// The thruster valve, as a type.
#[derive(Debug)]
pub enum Thruster {}

impl sealed::Sealed for Thruster {}

impl From<ThrusterCommand> for Command {
    fn from(command: ThrusterCommand) -> Self {
        Self::Thruster(command)
    }
}

impl Kind for Thruster {
    type Command = ThrusterCommand;
    const SAFING: ThrusterCommand = ThrusterCommand::Close;

    fn declare(command: &ThrusterCommand) -> Declaration {
        let (code, effect) = match command {
            ThrusterCommand::Open => (1, Effect::On { draw: THRUSTER_DRAW, flow: THRUSTER_FLOW }),
            ThrusterCommand::Close => (2, Effect::Off),
        };
        Declaration { code, wcet: COMMAND_TIME_MAX, effect }
    }

    fn profile(parameters: &Parameters) -> Profile {
        let mut profile = common_profile(parameters).drawing(THRUSTER_DRAW);
        profile.flow = THRUSTER_FLOW;
        profile
    }
}

/// What the thruster valve is and does.
#[derive(Clone, Debug, Default)]
pub(crate) struct ThrusterState {
    driven: bool,
    stuck: bool,
}

impl ThrusterState {
    /// Whether the solenoid is driven: what the sensor sees.
    pub(crate) fn is_on(&self) -> bool {
        self.driven
    }

    /// Whether propellant passes.
    pub(crate) fn is_open(&self) -> bool {
        self.driven || self.stuck
    }

    pub(crate) fn draw(&self) -> Milliwatts {
        if self.driven { THRUSTER_DRAW } else { Milliwatts::ZERO }
    }

    pub(crate) fn react(&mut self, command: ThrusterCommand) -> Reaction {
        let driven = command == ThrusterCommand::Open;
        if std::mem::replace(&mut self.driven, driven) == driven {
            Reaction::NoEffect
        } else {
            Reaction::Took
        }
    }

    /// From now on the valve is open, whatever the solenoid does.
    pub(crate) fn stick_open(&mut self) {
        self.stuck = true;
    }
}
