//! A heater: a switch and a resistor.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Instant;

use super::settings::Settings;
use super::unit::{Action, CommandHelp, Made, Switch, Unit};

/// An instrument's survival heater.
const DRAW: Milliwatts = Milliwatts::from_watts(6);

pub(crate) const COMMANDS: &[CommandHelp] =
    &[CommandHelp::plain("on", "begin to heat"), CommandHelp::plain("off", "end it")];

#[derive(Clone, Debug)]
pub(crate) struct Heater {
    switch: Switch,
    draw: Milliwatts,
}

impl Heater {
    pub(crate) fn read(settings: &mut Settings<'_>) -> (Self, Milliwatts) {
        let draw = settings.watts("draw_w", DRAW);
        // What it warms is for whoever plans with it.
        settings.name("zone");
        (Self { switch: Switch::OPEN, draw }, draw)
    }
}

impl Unit for Heater {
    fn is_on(&self) -> bool {
        self.switch.is_closed()
    }

    fn draw(&self, _: Instant) -> Milliwatts {
        self.switch.drawing(self.draw)
    }

    fn next_event(&self, _: Instant) -> Option<Instant> {
        None
    }

    fn happen(&mut self, _: Instant) {}

    fn react(&mut self, action: Action, _: Instant) -> bool {
        match action {
            Action::On => self.switch.set(true),
            Action::Off => self.switch.set(false),
            _ => false,
        }
    }

    fn made(&self, _: Instant) -> Made {
        Made::default()
    }
}
