//! The scale of time: where an instant is, and which times of day are named.

use crate::parameters::{Day, Parameters};
use crate::units::{Span, Time};
use crate::words::day_number;

/// From the first instant to the last one, over so many pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub(super) from: Time,
    pub(super) until: Time,
    pub(super) left: f64,
    pub(super) right: f64,
}

/// An instant that is named.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) at: Time,
    pub(super) label: String,
    /// Whether a day begins there.
    pub(super) midnight: bool,
}

const MINUTE: i64 = 60_000;

/// Minutes between two ticks, as people count them.
const STEPS: [i64; 10] = [1, 2, 5, 10, 15, 30, 60, 120, 180, 360];

/// Pixels between two ticks, at least.
const APART: f64 = 58.0;

impl Scale {
    pub(super) fn new(from: Time, until: Time, (left, right): (f64, f64)) -> Self {
        let until = until.max(from.after(Span::new(1)));
        Self { from, until, left, right }
    }

    /// The place of this instant; at an end, if it lies beyond.
    pub(super) fn place(&self, at: Time) -> f64 {
        let part = float(at.clamp(self.from, self.until).since(self.from).get())
            / float(self.until.since(self.from).get());
        self.left + part * (self.right - self.left)
    }

    /// Where a span begins and ends, if any of it can be seen.
    pub(super) fn seen(&self, from: Time, until: Time) -> Option<(f64, f64)> {
        let visible = until >= self.from && from <= self.until;
        visible.then(|| (self.place(from), self.place(until)))
    }

    fn pixels(&self, span: i64) -> f64 {
        float(span) / float(self.until.since(self.from).get()) * (self.right - self.left)
    }

    /// Round times of each day. Of the last one before midnight and midnight
    /// there is room for one.
    pub(super) fn ticks(&self, parameters: &Parameters) -> Vec<Tick> {
        let day = parameters.day;
        let (first, last) = (day_number(parameters, self.from), day_number(parameters, self.until));
        let Some(step) = STEPS.iter().find(|step| self.pixels(**step * MINUTE) >= APART) else {
            return self.days(parameters, first, last);
        };
        let mut ticks = Vec::new();
        for number in first..=last {
            ticks.extend(self.ticks_of(day, number, *step));
        }
        ticks.retain(|tick| (self.from..=self.until).contains(&tick.at));
        ticks
    }

    fn ticks_of(&self, day: Day, number: i64, step: i64) -> Vec<Tick> {
        let (begin, next) = (midnight(day, number), midnight(day, number.saturating_add(1)));
        let count = day.length.get() / MINUTE / step;
        let minutes = (0..=count).map(|nth| nth * step);
        let ticks = minutes.map(|minute| Tick {
            at: begin.after(Span::new(minute * MINUTE)),
            label: label(number, minute),
            midnight: minute == 0,
        });
        ticks.filter(|tick| self.pixels(next.since(tick.at).get()) >= APART * 0.7).collect()
    }

    /// Midnights alone, as many as there is room for.
    fn days(&self, parameters: &Parameters, first: i64, last: i64) -> Vec<Tick> {
        let day = parameters.day;
        let mut every = 1_i64;
        while self.pixels(day.length.get().saturating_mul(every)) < APART && every < last - first {
            every = every.saturating_mul(2);
        }
        let first = first.div_euclid(every).saturating_mul(every);
        let numbers = (0..=64).map(|nth| first.saturating_add(every.saturating_mul(nth)));
        let ticks = numbers.map(|number| Tick {
            at: midnight(day, number),
            label: label(number, 0),
            midnight: true,
        });
        ticks.filter(|tick| (self.from..=self.until).contains(&tick.at)).collect()
    }
}

/// The time of day; the sol where it begins.
fn label(number: i64, minute: i64) -> String {
    match minute {
        0 => format!("sol {number}"),
        _ => format!("{:02}:{:02}", minute / 60, minute % 60),
    }
}

/// When the day of this number begins.
pub(super) fn midnight(day: Day, number: i64) -> Time {
    day.midnight.after(Span::new(day.length.get().saturating_mul(number)))
}

/// For places in a picture alone: a pixel is far more than one part in 2^53.
#[expect(clippy::cast_precision_loss, reason = "a pixel is far more than one part in 2^53")]
pub(super) fn float(exact: i64) -> f64 {
    exact as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(from: i64, until: i64) -> Vec<String> {
        let scale = Scale::new(Time::new(from * 60_000), Time::new(until * 60_000), (0.0, 900.0));
        scale.ticks(&Parameters::default()).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn a_sol_is_named_by_its_hours_and_its_end_is_the_next_ones_midnight() {
        let named = labels(0, 1_480);
        assert_eq!(named.len(), 13, "{named:?}");
        assert_eq!(named[11..], ["22:00", "sol 1"]);
    }

    #[test]
    fn a_few_minutes_are_named_by_the_minute() {
        assert_eq!(labels(600, 610)[..3], ["10:00", "10:01", "10:02"]);
    }

    #[test]
    fn many_sols_are_named_by_their_numbers_with_room_between() {
        let named = labels(0, 1_480 * 100);
        assert!((4..=16).contains(&named.len()), "{named:?}");
        assert!(named[1].starts_with("sol "), "{named:?}");
    }

    #[test]
    fn no_plan_is_too_short_or_too_long_for_a_scale() {
        for until in [0, 1, i64::MAX / 60_000 / 8] {
            assert!(labels(0, until).len() <= 16, "{until}");
        }
    }
}
