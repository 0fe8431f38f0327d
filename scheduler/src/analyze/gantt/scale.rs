//! The scale of time: where an instant is, and which ones are named.

use crate::time::Duration;

/// From the load to the horizon, over this many pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    until: Duration,
    pub(super) left: f64,
    pub(super) right: f64,
}

/// What the numbers on the scale count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unit {
    pub(super) name: &'static str,
    micros: u64,
}

const MILLISECONDS: Unit = Unit { name: "ms", micros: 1_000 };
const SECONDS: Unit = Unit { name: "s", micros: 1_000_000 };
const MINUTES: Unit = Unit { name: "min", micros: 60_000_000 };
const HOURS: Unit = Unit { name: "h", micros: 3_600_000_000 };
const DAYS: Unit = Unit { name: "d", micros: 86_400_000_000 };

/// Steps that people count in.
const STEPS: [(Unit, &[u64]); 5] = [
    (MILLISECONDS, &[1, 2, 5, 10, 20, 50, 100, 200, 500]),
    (SECONDS, &[1, 2, 5, 10, 15, 30]),
    (MINUTES, &[1, 2, 5, 10, 15, 30]),
    (HOURS, &[1, 2, 3, 6, 12]),
    (DAYS, &[1, 2, 5, 7, 14, 28, 56, 91, 182, 364, 728]),
];

/// More hours than these are counted in days.
const COUNTED_HOURS: u64 = 96;

/// Pixels between two numbers, at least.
const APART: f64 = 62.0;

impl Scale {
    pub(super) fn new(until: Duration, left: f64, right: f64) -> Self {
        Self { until: until.max(Duration::from_millis(1)), left, right }
    }

    pub(super) const fn until(&self) -> Duration {
        self.until
    }

    /// The place of this instant; at the end, if it lies beyond.
    #[expect(clippy::cast_precision_loss, reason = "a pixel is far more than one part in 2^53")]
    pub(super) fn place(&self, at: Duration) -> f64 {
        let part = at.min(self.until).as_micros() as f64 / self.until.as_micros() as f64;
        self.left + part * (self.right - self.left)
    }

    /// The unit, and the instants that are named, with their numbers.
    pub(super) fn ticks(&self) -> (Unit, Vec<(Duration, u64)>) {
        let (unit, step) = self.step();
        let every = unit.micros.saturating_mul(step);
        let count = self.until.as_micros() / every;
        let ticks = (0..=count).map(|nth| (Duration::from_micros(nth * every), nth * step));
        (unit, ticks.collect())
    }

    /// The least step that leaves room for the numbers; beyond the longest, as
    /// often doubled as that takes.
    fn step(&self) -> (Unit, u64) {
        let in_days = self.until.as_micros() / HOURS.micros > COUNTED_HOURS;
        let fits = |unit: Unit, step: u64| {
            if unit == HOURS && in_days {
                return false;
            }
            let step = Duration::from_micros(unit.micros.saturating_mul(step));
            self.place(step) - self.left >= APART || step >= self.until
        };
        let all = STEPS.iter().flat_map(|(unit, steps)| steps.iter().map(|step| (*unit, *step)));
        let longer = (0..32).map(|doubled| (DAYS, 728_u64 << doubled));
        all.chain(longer).find(|(unit, step)| fits(*unit, *step)).unwrap_or((DAYS, u64::MAX))
    }
}

/// An instant in words, in the units that people use.
pub(super) fn say(at: Duration) -> String {
    let micros = at.as_micros();
    let seconds = micros / 1_000_000 % 60;
    let fraction = format!(".{:06}", micros % 1_000_000);
    let fraction = fraction.trim_end_matches('0').trim_end_matches('.');
    let whole = |unit: Unit, of: u64| (micros / unit.micros % of, unit.name);
    let large = [whole(DAYS, u64::MAX), whole(HOURS, 24), whole(MINUTES, 60)];
    let mut said: Vec<_> = large
        .into_iter()
        .filter(|(number, _)| *number > 0)
        .map(|(number, unit)| format!("{number} {unit}"))
        .collect();
    if said.is_empty() || seconds > 0 || !fraction.is_empty() {
        said.push(format!("{seconds}{fraction} s"));
    }
    said.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(seconds: u64) -> (&'static str, u64, usize) {
        let (unit, ticks) = Scale::new(Duration::from_secs(seconds), 0.0, 900.0).ticks();
        (unit.name, ticks.get(1).map_or(0, |tick| tick.1), ticks.len())
    }

    #[test]
    fn numbers_are_round_in_a_unit_that_fits() {
        assert_eq!(ticks(9), ("s", 1, 10));
        assert_eq!(ticks(45), ("s", 5, 10));
        assert_eq!(ticks(1_200), ("min", 2, 11));
        assert_eq!(ticks(86_400), ("h", 2, 13));
        assert_eq!(ticks(604_800), ("d", 1, 8));
    }

    #[test]
    fn no_schedule_is_too_short_or_too_long_for_numbers() {
        for micros in [0, 1, 999, u64::MAX / 1_000, u64::MAX] {
            let (_, ticks) = Scale::new(Duration::from_micros(micros), 0.0, 900.0).ticks();
            assert!((1..=16).contains(&ticks.len()), "{micros}: {}", ticks.len());
        }
    }

    #[test]
    fn instants_are_said_as_people_say_them() {
        let said = [9_500_000, 4_265_000_000, 90_061_000_000];
        let said = said.map(|micros| say(Duration::from_micros(micros)));
        assert_eq!(said, ["9.5 s", "1 h 11 min 5 s", "1 d 1 h 1 min 1 s"]);
    }
}
