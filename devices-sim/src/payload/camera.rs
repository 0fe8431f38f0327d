//! A camera: an inrush when it goes on, and exposures that are lost when it goes
//! off.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

use super::settings::Settings;
use super::unit::{Action, CommandHelp, Made, Switch, Unit, ahead, later};

/// A small imager: detector and electronics.
const STEADY: Milliwatts = Milliwatts::from_watts(7);
/// The same while its converters charge.
const INRUSH: Milliwatts = Milliwatts::from_watts(9);
/// How long they do.
const INRUSH_TIME: Duration = Duration::from_millis(20);
/// One frame, readout included.
const EXPOSURE: Duration = Duration::from_millis(400);

pub(crate) const COMMANDS: &[CommandHelp] = &[
    CommandHelp::plain("on", "switch the camera on"),
    CommandHelp::plain("off", "switch it off; an exposure in progress is lost"),
    CommandHelp::plain("expose", "take an image, if the camera is on and none is being taken"),
];

#[derive(Clone, Debug)]
pub(crate) struct Camera {
    switch: Switch,
    steady: Milliwatts,
    inrush: Milliwatts,
    inrush_time: Duration,
    exposure: Duration,
    inrush_ends: Option<Instant>,
    exposure_ends: Option<Instant>,
    made: Made,
}

impl Camera {
    pub(crate) fn read(settings: &mut Settings<'_>) -> (Self, Milliwatts) {
        let steady = settings.watts("draw_w", STEADY);
        let extra = INRUSH.saturating_sub(STEADY);
        let inrush = settings.watts("inrush_w", steady.saturating_add(extra)).max(steady);
        let camera = Self {
            switch: Switch::OPEN,
            steady,
            inrush,
            inrush_time: settings.seconds("inrush_s", INRUSH_TIME),
            exposure: settings.seconds("exposure_s", EXPOSURE),
            inrush_ends: None,
            exposure_ends: None,
            made: Made::default(),
        };
        (camera, inrush)
    }

    fn expose(&mut self, now: Instant) -> bool {
        let can = self.switch.is_closed() && self.exposure_ends.is_none();
        if can {
            self.exposure_ends = Some(later(now, self.exposure));
        }
        can
    }
}

impl Unit for Camera {
    fn is_on(&self) -> bool {
        self.switch.is_closed()
    }

    fn draw(&self, now: Instant) -> Milliwatts {
        let charging = ahead(self.inrush_ends, now).is_some();
        self.switch.drawing(if charging { self.inrush } else { self.steady })
    }

    fn next_event(&self, now: Instant) -> Option<Instant> {
        [self.inrush_ends, self.exposure_ends].into_iter().filter_map(|at| ahead(at, now)).min()
    }

    fn happen(&mut self, now: Instant) {
        if self.exposure_ends.take_if(|at| *at <= now).is_some() {
            self.made.finished += 1;
        }
    }

    fn react(&mut self, action: Action, now: Instant) -> bool {
        match action {
            Action::On => {
                let changed = self.switch.set(true);
                if changed {
                    self.inrush_ends = Some(now.after(self.inrush_time));
                }
                changed
            }
            Action::Off => {
                self.made.lost += u64::from(self.exposure_ends.take().is_some());
                self.inrush_ends = None;
                self.switch.set(false)
            }
            Action::Expose => self.expose(now),
            _ => false,
        }
    }

    fn made(&self, _: Instant) -> Made {
        self.made
    }
}
