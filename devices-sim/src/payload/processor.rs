//! A payload processor whose draw follows its load: 4 to 10 W, as on STP-H7.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Instant;

use super::settings::Settings;
use super::unit::{Action, CommandHelp, Made, Switch, Unit};

/// On, and nothing to do.
const IDLE: Milliwatts = Milliwatts::from_watts(4);
/// All cores busy.
const FULL: Milliwatts = Milliwatts::from_watts(10);

pub(crate) const COMMANDS: &[CommandHelp] = &[
    CommandHelp::plain("on", "switch the processor on, idle"),
    CommandHelp::plain("off", "switch it off"),
    CommandHelp::with("load", "PERCENT", "compute with this share of the processor"),
];

#[derive(Clone, Debug)]
pub(crate) struct Processor {
    switch: Switch,
    idle: Milliwatts,
    full: Milliwatts,
    percent: u8,
}

impl Processor {
    pub(crate) fn read(settings: &mut Settings<'_>) -> (Self, Milliwatts) {
        let idle = settings.watts("idle_w", IDLE);
        let full = settings.watts("full_w", FULL).max(idle);
        (Self { switch: Switch::OPEN, idle, full, percent: 0 }, full)
    }

    fn set_load(&mut self, percent: u8) -> bool {
        self.switch.is_closed() && std::mem::replace(&mut self.percent, percent) != percent
    }
}

impl Unit for Processor {
    fn is_on(&self) -> bool {
        self.switch.is_closed()
    }

    fn draw(&self, _: Instant) -> Milliwatts {
        let share = self.full.saturating_sub(self.idle).get() * u64::from(self.percent) / 100;
        self.switch.drawing(self.idle.saturating_add(Milliwatts::new(share)))
    }

    fn next_event(&self, _: Instant) -> Option<Instant> {
        None
    }

    fn happen(&mut self, _: Instant) {}

    fn react(&mut self, action: Action, _: Instant) -> bool {
        match action {
            Action::On => self.switch.set(true),
            Action::Off => {
                self.percent = 0;
                self.switch.set(false)
            }
            Action::Load(percent) => self.set_load(percent),
            _ => false,
        }
    }

    fn made(&self, _: Instant) -> Made {
        Made::default()
    }
}
