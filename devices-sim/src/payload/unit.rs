//! What the units of a payload have in common: commands by name, and a draw
//! that changes at events.

use std::fmt;

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::{Declaration, Effect};

/// A unit as the bus sees it. Between two of its events its draw is constant.
pub(crate) trait Unit: Send + fmt::Debug {
    /// Whether its power switch is closed: what the sensor sees.
    fn is_on(&self) -> bool;

    /// What it draws.
    fn draw(&self, now: Instant) -> Milliwatts;

    /// When something happens to it by itself, after `now`.
    fn next_event(&self, now: Instant) -> Option<Instant>;

    /// What happens to it at `now`.
    fn happen(&mut self, now: Instant);

    /// Does what a command says. Whether anything changed.
    fn react(&mut self, action: Action, now: Instant) -> bool;

    /// What it finished so far, and what it lost, in what it makes: images,
    /// kibibytes.
    fn made(&self, now: Instant) -> Made;
}

/// What a unit did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Made {
    pub(crate) finished: u64,
    pub(crate) lost: u64,
}

/// What a unit can be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Action {
    On,
    Off,
    /// One image.
    Expose,
    /// So many kibibytes to the ground.
    Send(u32),
    /// To this angle, in thousandths of a degree.
    Point(i32),
    /// Measure for so many milliseconds.
    Acquire(u32),
    /// Compute with this share of the processor, in percent.
    Load(u8),
}

impl Action {
    /// Its number in the flight recorder.
    const fn code(self) -> u16 {
        match self {
            Self::On => 1,
            Self::Off => 2,
            Self::Expose => 3,
            Self::Send(_) => 4,
            Self::Point(_) => 5,
            Self::Acquire(_) => 6,
            Self::Load(_) => 7,
        }
    }

    const fn argument(self) -> i64 {
        match self {
            Self::On | Self::Off | Self::Expose => 0,
            Self::Send(n) | Self::Acquire(n) => n as i64,
            Self::Point(n) => n as i64,
            Self::Load(n) => n as i64,
        }
    }

    fn of(code: u16, argument: i64) -> Option<Self> {
        Some(match code {
            1 => Self::On,
            2 => Self::Off,
            3 => Self::Expose,
            4 => Self::Send(argument.try_into().ok()?),
            5 => Self::Point(argument.try_into().ok()?),
            6 => Self::Acquire(argument.try_into().ok()?),
            7 => Self::Load(argument.try_into().ok()?),
            _ => return None,
        })
    }
}

/// A command to a unit, with what is declared of it. Made by
/// [`UnitSpec::parse`](super::UnitSpec::parse) alone: what it turns on is what
/// its unit declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct UnitCommand {
    pub(crate) action: Action,
    pub(crate) wcet: Duration,
    pub(crate) effect: Effect,
}

impl UnitCommand {
    /// What is declared of it.
    #[must_use]
    pub const fn declaration(self) -> Declaration {
        Declaration { code: self.action.code(), wcet: self.wcet, effect: self.effect }
    }

    /// Its argument, as a number; 0 where it has none.
    #[must_use]
    pub const fn argument(self) -> i64 {
        self.action.argument()
    }

    /// The command that has this declaration and argument, for a program that
    /// carries commands as numbers.
    #[must_use]
    pub fn from_numbers(declaration: Declaration, argument: i64) -> Option<Self> {
        let action = Action::of(declaration.code, argument)?;
        Some(Self { action, wcet: declaration.wcet, effect: declaration.effect })
    }
}

impl fmt::Display for UnitCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.action {
            Action::On => f.write_str("on"),
            Action::Off => f.write_str("off"),
            Action::Expose => f.write_str("expose"),
            Action::Send(kib) => write!(f, "send {kib}"),
            Action::Point(angle) => {
                let (sign, angle) = (if angle < 0 { "-" } else { "" }, angle.unsigned_abs());
                write!(f, "point {sign}{}.{:03}", angle / 1_000, angle % 1_000)
            }
            Action::Acquire(ms) => write!(f, "acquire {}.{:03}", ms / 1_000, ms % 1_000),
            Action::Load(percent) => write!(f, "load {percent}"),
        }
    }
}

/// What people are told of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandHelp {
    /// Its name.
    pub name: &'static str,
    /// Its argument, if it has one.
    pub argument: Option<&'static str>,
    /// What it does.
    pub help: &'static str,
}

impl CommandHelp {
    pub(crate) const fn plain(name: &'static str, help: &'static str) -> Self {
        Self { name, argument: None, help }
    }

    pub(crate) const fn with(
        name: &'static str,
        argument: &'static str,
        help: &'static str,
    ) -> Self {
        Self { name, argument: Some(argument), help }
    }
}

/// A switch, and what a unit draws while it is closed.
#[derive(Clone, Debug)]
pub(crate) struct Switch(bool);

impl Switch {
    pub(crate) const OPEN: Self = Self(false);

    pub(crate) const fn is_closed(&self) -> bool {
        self.0
    }

    /// Sets it; whether it was otherwise before.
    pub(crate) fn set(&mut self, closed: bool) -> bool {
        std::mem::replace(&mut self.0, closed) != closed
    }

    pub(crate) fn drawing(&self, draw: Milliwatts) -> Milliwatts {
        if self.0 { draw } else { Milliwatts::ZERO }
    }
}

/// When something that begins `now` ends: never in the same instant.
pub(crate) fn later(now: Instant, time: Duration) -> Instant {
    now.after(time.max(Duration::from_micros(1)))
}

/// What still lies ahead.
pub(crate) fn ahead(at: Option<Instant>, now: Instant) -> Option<Instant> {
    at.filter(|at| *at > now)
}
