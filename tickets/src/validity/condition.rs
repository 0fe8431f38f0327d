//! Conditions: what must be true of the spacecraft when a command is invoked.

use super::{Ask, Denial, Rule};
use crate::clock::Duration;
use crate::telemetry::{Channel, Modes};

/// A fresh value of a channel lies in a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct InRange {
    channel: Channel,
    min: i32,
    max: i32,
    max_age: Duration,
}

impl InRange {
    pub(super) const fn new(channel: Channel, min: i32, max: i32, max_age: Duration) -> Self {
        Self { channel, min, max, max_age }
    }

    pub(super) fn check(&self, ask: &Ask<'_>) -> Result<(), Denial> {
        let reading = ask.telemetry.and_then(|table| table.read(self.channel, ask.now));
        let too_old = match reading {
            Some(reading) => reading.age.saturating_sub(self.max_age).as_micros(),
            None => u64::MAX,
        };
        denied_by(Rule::TelemetryAge, too_old)?;
        denied_by(Rule::Telemetry, reading.map_or(0, |reading| self.outside_by(reading.value)))
    }

    fn outside_by(&self, value: i32) -> u64 {
        let below = if value < self.min { value.abs_diff(self.min) } else { 0 };
        let above = if value > self.max { value.abs_diff(self.max) } else { 0 };
        u64::from(below.max(above))
    }
}

fn denied_by(rule: Rule, short_by: u64) -> Result<(), Denial> {
    if short_by == 0 {
        return Ok(());
    }
    Err(Denial { rule, short_by, until: None })
}

/// The spacecraft is in one of some modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct InModes {
    modes: Modes,
}

impl InModes {
    pub(super) const fn new(modes: Modes) -> Self {
        Self { modes }
    }

    pub(super) fn check(&self, ask: &Ask<'_>) -> Result<(), Denial> {
        if ask.telemetry.is_some_and(|table| self.modes.contains(table.mode())) {
            return Ok(());
        }
        Err(Denial::by(Rule::Mode))
    }
}
