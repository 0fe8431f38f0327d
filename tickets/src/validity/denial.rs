//! What a validity function says when it does not agree.

use core::fmt;

use crate::clock::Instant;

/// Why a validity function did not agree, and by how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Denial {
    /// The rule that refuses.
    pub rule: Rule,
    /// What is missing, in the unit that the [`Rule`] names.
    pub short_by: u64,
    /// When this rule would agree, if nothing else happens until then; `None`
    /// where that is never, or not known.
    pub until: Option<Instant>,
}

impl Denial {
    /// A denial by a rule under which nothing can be short.
    pub(crate) const fn by(rule: Rule) -> Self {
        Self { rule, short_by: 0, until: None }
    }
}

impl fmt::Display for Denial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.rule)?;
        match (self.rule, self.short_by) {
            (Rule::TelemetryAge, u64::MAX) => write!(f, ": never measured")?,
            (_, 0) => {}
            (rule, short_by) => write!(f, ": short by {short_by} {}", rule.unit())?,
        }
        match self.until {
            Some(until) => write!(f, ", until {until}"),
            None => Ok(()),
        }
    }
}

impl core::error::Error for Denial {}

/// The rule that refused or ran out. Each names the unit of
/// [`short_by`](Denial::short_by).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rule {
    /// The window is not open: microseconds until it opens, or since it closed.
    Window,
    /// The time since the first On command is over: microseconds since then.
    TimeLimit,
    /// All commands are used: one command.
    Invocations,
    /// Too many commands lately: microseconds until the next.
    Rate,
    /// Too soon after the last command: microseconds until the next.
    Separation,
    /// The device must rest: microseconds of rest that are missing.
    DutyCycle,
    /// The energy is used up: microjoules that a larger budget would need.
    Energy,
    /// The propellant is used up: milligrams that a larger budget would need.
    Propellant,
    /// The other side of the interlock may be on: always 0.
    Interlock,
    /// The value is outside its range: units of the channel.
    Telemetry,
    /// The value was measured too long ago: microseconds too old; `u64::MAX`
    /// where it was never measured.
    TelemetryAge,
    /// The spacecraft is in another mode: always 0.
    Mode,
    /// The holder was silent for too long: microseconds since the lease ended.
    Lease,
}

impl Rule {
    const fn unit(self) -> &'static str {
        match self {
            Self::Invocations => "command",
            Self::Energy => "uJ",
            Self::Propellant => "mg",
            Self::Telemetry => "units",
            Self::Interlock | Self::Mode => "",
            Self::Window
            | Self::TimeLimit
            | Self::Rate
            | Self::Separation
            | Self::DutyCycle
            | Self::TelemetryAge
            | Self::Lease => "us",
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Window => "outside its window",
            Self::TimeLimit => "time limit reached",
            Self::Invocations => "all commands used",
            Self::Rate => "command rate exceeded",
            Self::Separation => "too soon after the last command",
            Self::DutyCycle => "duty cycle exceeded",
            Self::Energy => "energy budget used up",
            Self::Propellant => "propellant budget used up",
            Self::Interlock => "interlocked",
            Self::Telemetry => "telemetry out of range",
            Self::TelemetryAge => "telemetry too old",
            Self::Mode => "not in this mode",
            Self::Lease => "lease ended",
        })
    }
}

/// A limit ran out, and the device has to go off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RanOut {
    /// The rule whose limit it was.
    pub rule: Rule,
    /// Whether the ticket can never be used again. A device that only has to
    /// rest gets its ticket back: see
    /// [`rests_until`](super::Validity::rests_until).
    pub ends_ticket: bool,
}

impl RanOut {
    /// The end of the ticket.
    pub(super) const fn ends(rule: Rule) -> Self {
        Self { rule, ends_ticket: true }
    }
}
