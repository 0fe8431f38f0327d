//! Thermal zones: straight lines between instants, in billionths of a degree. A
//! thousandth of a degree in a second is a billionth in a microsecond, so nothing
//! is rounded.

use faregate_tickets::clock::{Duration, Instant};

use super::model::ZoneModel;

/// Thousandths in billionths.
const MILLI: i64 = 1_000_000;
/// How much warmer than needed the thermostat lets a zone become.
const OVERSHOOT: i64 = 5_000;

/// A zone, as it is.
#[derive(Clone, Debug)]
pub(super) struct Zone {
    pub(super) model: ZoneModel,
    temperature: i64,
    pub(super) heater_on: bool,
    pub(super) driver_taken: bool,
}

impl Zone {
    pub(super) fn new(model: ZoneModel, time_of_day: Duration) -> Self {
        let temperature = surroundings(&model, time_of_day).saturating_mul(MILLI);
        Self { model, temperature, heater_on: false, driver_taken: false }
    }

    /// How warm it is, in thousandths of a degree, rounded down.
    pub(super) fn temperature(&self) -> i64 {
        self.temperature.div_euclid(MILLI)
    }

    /// Lets time pass. A zone in use keeps itself as warm as it is.
    pub(super) fn pass(&mut self, time: Duration, warms: bool, used: bool, time_of_day: Duration) {
        let us = i64::try_from(time.as_micros()).unwrap_or(i64::MAX);
        let warmest = self.model.needed.saturating_add(OVERSHOOT).saturating_mul(MILLI);
        if warms {
            let risen = self.temperature.saturating_add(self.model.warms.saturating_mul(us));
            self.temperature = risen.min(warmest).max(self.temperature);
        } else if !used {
            let target = surroundings(&self.model, time_of_day).saturating_mul(MILLI);
            let step = self.model.cools.saturating_mul(us);
            let (low, high) =
                (self.temperature.saturating_sub(step), self.temperature.saturating_add(step));
            self.temperature = target.clamp(low, high);
        }
    }
}

fn surroundings(zone: &ZoneModel, time_of_day: Duration) -> i64 {
    let rows = &zone.surroundings;
    let row = rows.iter().rfind(|(from, _)| *from <= time_of_day).or(rows.last());
    row.map_or(zone.needed, |(_, warm)| *warm)
}

/// The next instant after `now` at which a row of some zone begins.
pub(super) fn next_row(
    zones: &[Zone],
    now: Instant,
    time_of_day: Duration,
    day: Duration,
) -> Option<Instant> {
    let until = |from: &Duration| {
        let passed = from.as_micros() <= time_of_day.as_micros();
        let day = if passed { day } else { Duration::ZERO };
        day.saturating_add(*from).saturating_sub(time_of_day)
    };
    let rows = zones.iter().flat_map(|zone| &zone.model.surroundings);
    let next = rows.map(|(from, _)| until(from)).filter(|until| !until.is_zero()).min();
    next.map(|until| now.after(until))
}
