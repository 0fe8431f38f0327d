//! What the rounds of a row came to.

use std::time::Duration;

use hdrhistogram::Histogram;

use super::Outcome;
use super::stage::Answer;

/// The longest time that is told from longer ones.
const LONGEST_NS: u64 = 60_000_000_000;

/// All rounds of one row.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// Nanoseconds. A round in which the holder was not caught inside has
    /// none: a host that kept the revoker from running let the holder go.
    times: Histogram<u64>,
    rounds: u64,
    /// In so many rounds the holder was inside when time began to be taken.
    pub(crate) caught: u64,
    /// In so many rounds who waited gave up.
    pub(crate) gave_up: u64,
    /// In so many rounds the hog had done all its work by then.
    pub(crate) hog_first: u64,
    /// So many commands reached the device after quiescence.
    pub(crate) late: u64,
    /// In so many rounds a store was called back.
    pub(crate) called_back: u64,
    /// The longest of those.
    pub(crate) called_back_max: Duration,
}

impl Measured {
    pub(crate) fn new() -> Outcome<Self> {
        let times = Histogram::new_with_bounds(1, LONGEST_NS, 3)?;
        Ok(Self {
            times,
            rounds: 0,
            caught: 0,
            gave_up: 0,
            hog_first: 0,
            late: 0,
            called_back: 0,
            called_back_max: Duration::ZERO,
        })
    }

    pub(crate) fn rounds(&self) -> u64 {
        self.rounds
    }

    pub(crate) fn add(&mut self, took: Duration, caught: bool, answer: Answer) {
        self.rounds += 1;
        self.caught += u64::from(caught);
        if caught {
            self.record(took, answer);
        }
    }

    /// A round in which it is not told whether somebody was caught.
    pub(crate) fn time(&mut self, took: Duration, answer: Answer) {
        self.rounds += 1;
        self.record(took, answer);
    }

    fn record(&mut self, took: Duration, answer: Answer) {
        self.gave_up += u64::from(answer == Answer::GaveUp);
        self.times.saturating_record(u64::try_from(took.as_nanos()).unwrap_or(LONGEST_NS));
    }

    /// The time that this part of the rounds did not exceed; nothing where
    /// there are too few rounds to tell it from the longest.
    pub(crate) fn quantile_us(&self, part: f64) -> Option<f64> {
        let beyond = (1.0 - part) * self.times.len() as f64;
        // 0.01 * 100 is a little less than one.
        (beyond > 0.999).then(|| us(self.times.value_at_quantile(part)))
    }

    pub(crate) fn max_us(&self) -> f64 {
        us(self.times.max())
    }

    /// What part of the rounds took from `from_us` to less than `to_us`.
    pub(crate) fn part_within(&self, from_us: f64, to_us: f64) -> f64 {
        let ns = |us: f64| Duration::from_secs_f64(us / 1e6).as_nanos().try_into().unwrap_or(0);
        let (from, to) = (ns(from_us), ns(to_us));
        let within: u64 = self
            .times
            .iter_recorded()
            .filter(|value| (from..to).contains(&value.value_iterated_to()))
            .map(|value| value.count_at_value())
            .sum();
        within as f64 / (self.times.len() as f64).max(1.0)
    }
}

fn us(ns: u64) -> f64 {
    ns as f64 / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(us: impl IntoIterator<Item = u64>) -> Measured {
        let mut measured = Measured::new().expect("the bounds are in order");
        us.into_iter().for_each(|us| measured.time(Duration::from_micros(us), Answer::Done));
        measured
    }

    fn near(value: Option<f64>, expected: f64) -> bool {
        value.is_some_and(|value| (value / expected - 1.0).abs() < 2e-3)
    }

    #[test]
    fn quantiles_are_those_of_the_times() {
        let measured = of(1..=1000);
        assert!(near(measured.quantile_us(0.5), 500.0), "{:?}", measured.quantile_us(0.5));
        assert!(near(measured.quantile_us(0.99), 990.0), "{:?}", measured.quantile_us(0.99));
        assert!(near(measured.quantile_us(0.999), 999.0));
        assert!(near(Some(measured.max_us()), 1000.0));
    }

    #[test]
    fn a_quantile_that_few_rounds_cannot_tell_is_not_told() {
        assert!(of(1..=99).quantile_us(0.99).is_none());
        assert!(of(1..=100).quantile_us(0.99).is_some());
        assert!(of(1..=100).quantile_us(0.999).is_none());
        assert!(of([]).quantile_us(0.5).is_none());
    }

    #[test]
    fn a_round_in_which_the_holder_had_left_has_no_time() {
        let mut measured = of(1..=9);
        measured.add(Duration::from_secs(1), false, Answer::Done);
        assert_eq!((measured.rounds(), measured.caught), (10, 0));
        assert!(near(Some(measured.max_us()), 9.0));
    }

    #[test]
    fn every_time_is_within_one_of_the_parts() {
        let measured = of([1, 5, 50, 50, 5_000]);
        let edges = [0.1, 1.0, 10.0, 100.0, 1e3, 1e4];
        let parts = edges.windows(2).map(|edge| measured.part_within(edge[0], edge[1]));
        let parts: Vec<_> = parts.collect();
        assert_eq!(parts, [0.0, 0.4, 0.4, 0.0, 0.2]);
    }

    #[test]
    fn what_takes_longer_than_can_be_told_is_counted_all_the_same() {
        let measured = of([u64::MAX / 1_000_000]);
        assert_eq!(measured.rounds(), 1);
        assert!(measured.max_us() > 1e6);
    }
}
