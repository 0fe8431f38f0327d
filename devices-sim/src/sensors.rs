//! Sensors: they measure now and then, the estimate arrives later, and some
//! measurements say nothing. To command is not to know.
//!
//! Nothing is sampled ahead of time: a sensor keeps the history of what it
//! looks at, and a question is answered from the last measurement that has
//! arrived. So an answer does not depend on who asked before.

use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::{Estimate, Power};

use crate::device::DeviceId;
use crate::faults::{Fault, FaultScript};
use crate::parameters::Parameters;
use crate::random::mix;

/// What a sensor measured, and when. Not what is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Measured<T> {
    /// What.
    pub value: T,
    /// When it was measured; not when it arrived.
    pub measured_at: Instant,
}

/// A value that changes at instants.
#[derive(Clone, Debug)]
pub(crate) struct History<T>(Vec<(Instant, T)>);

impl<T: Copy + PartialEq> History<T> {
    pub(crate) fn new(value: T) -> Self {
        Self(vec![(Instant::START, value)])
    }

    /// The value from `now` on.
    pub(crate) fn push(&mut self, now: Instant, value: T) {
        if self.0.last().is_none_or(|(_, last)| *last != value) {
            self.0.push((now, value));
        }
    }

    /// The value at `instant`, and since when.
    fn at(&self, instant: Instant) -> Option<(Instant, T)> {
        let later = self.0.partition_point(|(since, _)| *since <= instant);
        self.0.get(later.checked_sub(1)?).copied()
    }
}

/// A sensor's rhythm and its failings.
#[derive(Clone, Debug)]
pub(crate) struct Sensor {
    period: Duration,
    lag: Duration,
    phase: Duration,
    unknown_permille: u64,
    noise: u64,
}

impl Sensor {
    /// A sensor whose phase and noise come from the seed and its number.
    pub(crate) fn new(number: u64, seed: u64, parameters: &Parameters) -> Self {
        let noise = mix(seed ^ mix(number.wrapping_add(1)));
        let phase_us = noise.checked_rem(parameters.sensor_period.as_micros()).unwrap_or(0);
        Self {
            period: parameters.sensor_period,
            lag: parameters.sensor_lag,
            phase: Duration::from_micros(phase_us),
            unknown_permille: u64::from(parameters.sensor_unknown_permille),
            noise,
        }
    }

    /// When the last measurement was made that has arrived by `now`.
    fn last_measurement(&self, now: Instant) -> Option<Instant> {
        let arrived = now.as_micros().checked_sub(self.lag.as_micros())?;
        self.measurement_by(Instant::from_micros(arrived))
    }

    /// When the last measurement up to `instant` was made.
    fn measurement_by(&self, instant: Instant) -> Option<Instant> {
        let since_first = instant.as_micros().checked_sub(self.phase.as_micros())?;
        let into_period = since_first.checked_rem(self.period.as_micros()).unwrap_or(0);
        Some(Instant::from_micros(instant.as_micros() - into_period))
    }

    fn says_nothing(&self, measured_at: Instant) -> bool {
        mix(self.noise ^ measured_at.as_micros()) % 1_000 < self.unknown_permille
    }

    /// What it measured last, of something without noise.
    pub(crate) fn measured<T: Copy + PartialEq>(
        &self,
        history: &History<T>,
        now: Instant,
    ) -> Option<Measured<T>> {
        let (measured, _) = self.measured_since(history, now)?;
        Some(measured)
    }

    /// The same, and since when it had been so.
    pub(crate) fn measured_since<T: Copy + PartialEq>(
        &self,
        history: &History<T>,
        now: Instant,
    ) -> Option<(Measured<T>, Instant)> {
        let measured_at = self.last_measurement(now)?;
        let (since, value) = history.at(measured_at)?;
        Some((Measured { value, measured_at }, since))
    }

    /// What it says about a device's switch.
    pub(crate) fn estimate(
        &self,
        device: DeviceId,
        switch: &History<bool>,
        script: &FaultScript,
        now: Instant,
    ) -> Option<Estimate> {
        let measured_at = self.last_spoken(device, script, self.last_measurement(now)?)?;
        let (_, on) = switch.at(measured_at)?;
        let state = match on {
            _ if self.says_nothing(measured_at) || is_blind(device, script, measured_at) => {
                Power::Unknown
            }
            true => Power::On,
            false => Power::Off,
        };
        Some(Estimate { state, measured_at })
    }

    /// The last measurement up to this one that was made at all.
    fn last_spoken(
        &self,
        device: DeviceId,
        script: &FaultScript,
        mut measured_at: Instant,
    ) -> Option<Instant> {
        while let Some(silent_from) = silent_from(device, script, measured_at) {
            let before = silent_from.as_micros().checked_sub(1)?;
            measured_at = self.measurement_by(Instant::from_micros(before))?;
        }
        Some(measured_at)
    }
}

fn silent_from(device: DeviceId, script: &FaultScript, at: Instant) -> Option<Instant> {
    script.iter().find_map(|fault| match fault {
        Fault::SensorSilent { device: d, from, until }
            if d == device && from <= at && at < until =>
        {
            Some(from)
        }
        _ => None,
    })
}

fn is_blind(device: DeviceId, script: &FaultScript, at: Instant) -> bool {
    script.iter().any(|fault| {
        matches!(fault, Fault::SensorBlind { device: d, from, until } if d == device && from <= at && at < until)
    })
}
