//! The catalyst bed heaters. They share the propulsion converter with the
//! thruster valve, and the converter cannot feed both.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::device::{Declaration, Effect, Profile};

use crate::device::{Command, Kind, common_profile, sealed};
use crate::parameters::{COMMAND_TIME_MAX, HEATERS_DRAW, Parameters};
use crate::plant::Reaction;

/// The heaters' command set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HeatersCommand {
    /// All heaters on.
    On,
    /// All heaters off.
    Off,
}

/// The catalyst bed heaters, as a type.
#[derive(Debug)]
pub enum Heaters {}

impl sealed::Sealed for Heaters {}

impl From<HeatersCommand> for Command {
    fn from(command: HeatersCommand) -> Self {
        Self::Heaters(command)
    }
}

impl Kind for Heaters {
    type Command = HeatersCommand;
    const SAFING: HeatersCommand = HeatersCommand::Off;

    fn declare(command: &HeatersCommand) -> Declaration {
        let (code, effect) = match command {
            HeatersCommand::On => (1, Effect::on(HEATERS_DRAW)),
            HeatersCommand::Off => (2, Effect::Off),
        };
        Declaration { code, wcet: COMMAND_TIME_MAX, effect }
    }

    fn profile(parameters: &Parameters) -> Profile {
        common_profile(parameters).drawing(HEATERS_DRAW)
    }
}

/// What the heaters are and do.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeatersState {
    on: bool,
}

impl HeatersState {
    pub(crate) fn is_on(&self) -> bool {
        self.on
    }

    pub(crate) fn draw(&self) -> Milliwatts {
        if self.on { HEATERS_DRAW } else { Milliwatts::ZERO }
    }

    pub(crate) fn react(&mut self, command: HeatersCommand) -> Reaction {
        let on = command == HeatersCommand::On;
        if std::mem::replace(&mut self.on, on) == on { Reaction::NoEffect } else { Reaction::Took }
    }
}
