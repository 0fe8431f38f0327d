//! An instrument computer: it boots, then it acquires what its instrument
//! measures. What is not finished when it goes off is lost.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

use super::settings::Settings;
use super::unit::{Action, CommandHelp, Made, Switch, Unit, ahead, later};

/// Booted, and its instrument idle.
const IDLE: Milliwatts = Milliwatts::from_watts(5);
/// While it boots or acquires.
const BUSY: Milliwatts = Milliwatts::from_watts(8);
/// From power-on until it takes commands.
const BOOT: Duration = Duration::from_secs(2);

pub(crate) const COMMANDS: &[CommandHelp] = &[
    CommandHelp::plain("on", "switch the computer on; it boots"),
    CommandHelp::plain("off", "switch it off; an acquisition in progress is lost"),
    CommandHelp::with(
        "acquire",
        "SECONDS",
        "measure for so long, if it has booted and is not measuring",
    ),
];

#[derive(Clone, Debug)]
pub(crate) struct Computer {
    switch: Switch,
    idle: Milliwatts,
    busy: Milliwatts,
    boot: Duration,
    boot_ends: Option<Instant>,
    acquisition_ends: Option<Instant>,
    made: Made,
}

impl Computer {
    pub(crate) fn read(settings: &mut Settings<'_>) -> (Self, Milliwatts) {
        let idle = settings.watts("idle_w", IDLE);
        let busy = settings.watts("busy_w", BUSY).max(idle);
        let computer = Self {
            switch: Switch::OPEN,
            idle,
            busy,
            boot: settings.seconds("boot_s", BOOT),
            boot_ends: None,
            acquisition_ends: None,
            made: Made::default(),
        };
        (computer, busy)
    }

    fn acquire(&mut self, ms: u32, now: Instant) -> bool {
        let can = self.switch.is_closed()
            && ahead(self.boot_ends, now).is_none()
            && self.acquisition_ends.is_none();
        if can {
            self.acquisition_ends = Some(later(now, Duration::from_millis(ms.into())));
        }
        can
    }
}

impl Unit for Computer {
    fn is_on(&self) -> bool {
        self.switch.is_closed()
    }

    fn draw(&self, now: Instant) -> Milliwatts {
        let busy = self.acquisition_ends.is_some() || ahead(self.boot_ends, now).is_some();
        self.switch.drawing(if busy { self.busy } else { self.idle })
    }

    fn next_event(&self, now: Instant) -> Option<Instant> {
        [self.boot_ends, self.acquisition_ends].into_iter().filter_map(|at| ahead(at, now)).min()
    }

    fn happen(&mut self, now: Instant) {
        if self.acquisition_ends.take_if(|at| *at <= now).is_some() {
            self.made.finished += 1;
        }
    }

    fn react(&mut self, action: Action, now: Instant) -> bool {
        match action {
            Action::On => {
                let changed = self.switch.set(true);
                if changed {
                    self.boot_ends = Some(now.after(self.boot));
                }
                changed
            }
            Action::Off => {
                self.made.lost += u64::from(self.acquisition_ends.take().is_some());
                self.boot_ends = None;
                self.switch.set(false)
            }
            Action::Acquire(ms) => self.acquire(ms, now),
            _ => false,
        }
    }

    fn made(&self, _: Instant) -> Made {
        self.made
    }
}
