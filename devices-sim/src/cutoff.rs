//! The cutoff valve: a latching valve between tank and thrusters. Its coil
//! draws much for a short time; once shut it stays shut without power.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Instant;
use faregate_tickets::device::{Declaration, Effect, Profile};

use crate::device::{Command, Kind, common_profile, sealed};
use crate::parameters::{COMMAND_TIME_MAX, CUTOFF_DRAW, Parameters};
use crate::plant::Reaction;

/// The cutoff valve's command set. To open it again is for the ground, with a
/// pyrotechnic bypass: it is no command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CutoffCommand {
    /// Drive the coil; the valve is shut when it has pulled in.
    Shut,
    /// Stop driving the coil. The valve stays where it is: shut, if the coil
    /// had pulled in.
    CoilOff,
}

/// The cutoff valve, as a type.
#[derive(Debug)]
pub enum Cutoff {}

impl sealed::Sealed for Cutoff {}

impl From<CutoffCommand> for Command {
    fn from(command: CutoffCommand) -> Self {
        Self::Cutoff(command)
    }
}

impl Kind for Cutoff {
    type Command = CutoffCommand;
    const SAFING: CutoffCommand = CutoffCommand::CoilOff;

    fn declare(command: &CutoffCommand) -> Declaration {
        let (code, effect) = match command {
            CutoffCommand::Shut => (1, Effect::on(CUTOFF_DRAW)),
            CutoffCommand::CoilOff => (2, Effect::Off),
        };
        Declaration { code, wcet: COMMAND_TIME_MAX, effect }
    }

    fn profile(parameters: &Parameters) -> Profile {
        common_profile(parameters).drawing(CUTOFF_DRAW)
    }
}

/// What the cutoff valve is and does.
#[derive(Clone, Debug, Default)]
pub(crate) struct CutoffState {
    coil_on_since: Option<Instant>,
    shut: bool,
}

impl CutoffState {
    /// Whether the coil is driven: what the power sensor sees.
    pub(crate) fn is_on(&self) -> bool {
        self.coil_on_since.is_some()
    }

    /// Whether it keeps propellant from passing.
    pub(crate) fn is_shut(&self) -> bool {
        self.shut
    }

    pub(crate) fn draw(&self) -> Milliwatts {
        if self.is_on() { CUTOFF_DRAW } else { Milliwatts::ZERO }
    }

    pub(crate) fn next_event(&self, now: Instant, parameters: &Parameters) -> Option<Instant> {
        let since = self.coil_on_since?;
        let pulled_in = since.after(parameters.cutoff_pull_in);
        let pulse_ends = since.after(parameters.cutoff_pulse);
        [pulled_in, pulse_ends].into_iter().filter(|at| *at > now).min()
    }

    pub(crate) fn happen(&mut self, now: Instant, parameters: &Parameters) {
        let Some(since) = self.coil_on_since else {
            return;
        };
        self.shut |= now >= since.after(parameters.cutoff_pull_in);
        if now >= since.after(parameters.cutoff_pulse) {
            self.coil_on_since = None;
        }
    }

    pub(crate) fn react(&mut self, command: CutoffCommand, now: Instant) -> Reaction {
        match command {
            CutoffCommand::Shut if !self.is_on() => self.coil_on_since = Some(now),
            CutoffCommand::CoilOff if self.is_on() => self.coil_on_since = None,
            _ => return Reaction::NoEffect,
        }
        Reaction::Took
    }
}
