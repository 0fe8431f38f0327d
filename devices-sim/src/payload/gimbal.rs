//! A gimbal: it holds an angle, and draws more while it turns to another.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

use super::settings::Settings;
use super::unit::{Action, CommandHelp, Made, Switch, Unit, ahead, later};

/// Holding an angle.
const HOLDING: Milliwatts = Milliwatts::from_watts(3);
/// Turning.
const TURNING: Milliwatts = Milliwatts::from_watts(12);
/// Thousandths of a degree in a second.
const RATE: u64 = 5_000;

pub(crate) const COMMANDS: &[CommandHelp] = &[
    CommandHelp::plain("on", "switch the motors on; they hold the present angle"),
    CommandHelp::plain("off", "switch them off; a turn in progress ends where it is"),
    CommandHelp::with("point", "DEGREES", "turn to this angle, -180 to 180"),
];

#[derive(Clone, Debug)]
pub(crate) struct Gimbal {
    switch: Switch,
    holding: Milliwatts,
    turning: Milliwatts,
    /// Thousandths of a degree in a second.
    rate: u64,
    /// Thousandths of a degree.
    angle: i64,
    turn: Option<Turn>,
    made: Made,
}

#[derive(Clone, Copy, Debug)]
struct Turn {
    began: Instant,
    ends: Instant,
    from: i64,
    to: i64,
}

impl Gimbal {
    pub(crate) fn read(settings: &mut Settings<'_>) -> (Self, Milliwatts) {
        let holding = settings.watts("holding_w", HOLDING);
        let turning = settings.watts("turning_w", TURNING).max(holding);
        let gimbal = Self {
            switch: Switch::OPEN,
            holding,
            turning,
            rate: settings.thousandths("rate_deg_s").unwrap_or(RATE).max(1),
            angle: 0,
            turn: None,
            made: Made::default(),
        };
        (gimbal, turning)
    }

    fn angle(&self, now: Instant) -> i64 {
        let Some(turn) = self.turn else { return self.angle };
        let whole = turn.ends.since(turn.began).as_micros().max(1);
        let part = now.since(turn.began).as_micros().min(whole);
        let moved = i128::from(turn.to - turn.from) * i128::from(part) / i128::from(whole);
        turn.from + i64::try_from(moved).unwrap_or(0)
    }

    fn point(&mut self, to: i64, now: Instant) -> bool {
        let from = self.angle(now);
        if !self.switch.is_closed() || from == to {
            return false;
        }
        self.angle = from;
        self.made.lost += u64::from(self.turn.is_some());
        let time = Duration::from_micros((to - from).unsigned_abs() * 1_000_000 / self.rate);
        self.turn = Some(Turn { began: now, ends: later(now, time), from, to });
        true
    }
}

impl Unit for Gimbal {
    fn is_on(&self) -> bool {
        self.switch.is_closed()
    }

    fn draw(&self, _: Instant) -> Milliwatts {
        self.switch.drawing(if self.turn.is_some() { self.turning } else { self.holding })
    }

    fn next_event(&self, now: Instant) -> Option<Instant> {
        ahead(self.turn.map(|turn| turn.ends), now)
    }

    fn happen(&mut self, now: Instant) {
        if let Some(turn) = self.turn.take_if(|turn| turn.ends <= now) {
            self.angle = turn.to;
            self.made.finished += 1;
        }
    }

    fn react(&mut self, action: Action, now: Instant) -> bool {
        match action {
            Action::On => self.switch.set(true),
            Action::Off => {
                self.angle = self.angle(now);
                self.made.lost += u64::from(self.turn.take().is_some());
                self.switch.set(false)
            }
            Action::Point(angle) => self.point(angle.into(), now),
            _ => false,
        }
    }

    fn made(&self, _: Instant) -> Made {
        self.made
    }
}
