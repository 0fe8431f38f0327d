//! When two routine tasks first want the same, and how often: by arithmetic on
//! whole microseconds, not by trying.

use crate::analyze::phase::Phase;

/// Two routine tasks that overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Meeting {
    /// When both run for the first time.
    pub(super) first: u64,
    /// How often the whole pattern repeats: the least common multiple of the
    /// intervals; none: beyond every mission.
    pub(super) every: Option<u64>,
}

/// A routine task as this arithmetic sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Routine {
    pub(super) phase: Phase,
    /// How long it keeps what it has.
    pub(super) length: u64,
}

impl Routine {
    fn due(self, occurrence: i128) -> i128 {
        i128::from(self.phase.first) + occurrence * i128::from(self.phase.interval)
    }
}

/// Longer than this is never: 146 000 years. Products of two stay in range.
const NEVER: u64 = 1 << 62;

/// When the two first overlap, if both always run when they are due.
///
/// Occurrence k of `a` begins at some place in the cycle of `b`. It meets the
/// run of `b` before it if that place is less than the length of `b`, and the
/// run after it if what is left of the cycle is less than its own length. In the
/// cycle, that is one interval: the first k whose place is in it is found like a
/// greatest common divisor.
pub(super) fn meeting(a: Routine, b: Routine) -> Option<Meeting> {
    let times = [a, b].map(|task| task.phase.first.max(task.phase.interval).max(task.length));
    if a.length == 0 || b.length == 0 || times.into_iter().any(|time| time > NEVER) {
        return None;
    }
    let cycle = i128::from(b.phase.interval);
    // The runs of `a` that are over when `b` begins meet nothing.
    let over = i128::from(b.phase.first) - i128::from(a.length) - i128::from(a.phase.first);
    let skipped =
        if over < 0 { 0 } else { over.div_euclid(i128::from(a.phase.interval)).saturating_add(1) };
    let place = a.due(skipped) - i128::from(b.phase.first) + i128::from(a.length) - 1;
    let wide = i128::from(a.length) + i128::from(b.length) - 1;
    let after = first_within(place, i128::from(a.phase.interval), cycle, wide)?;
    let begins = a.due(skipped.saturating_add(after));
    let first = u64::try_from(begins.max(meets(begins, a, b))).ok()?;
    Some(Meeting { first, every: least_common_multiple(a.phase.interval, b.phase.interval) })
}

/// When the run of `b` begins that a run of `a`, from this instant, meets.
fn meets(begins: i128, a: Routine, b: Routine) -> i128 {
    let passed = (begins - i128::from(b.phase.first)).div_euclid(i128::from(b.phase.interval));
    let before = b.due(passed.max(0));
    if before + i128::from(b.length) > begins && before < begins + i128::from(a.length) {
        before
    } else {
        b.due(passed.max(0).saturating_add(1))
    }
}

/// The least k >= 0 with `(place + k * step) mod cycle < wide`.
fn first_within(place: i128, step: i128, cycle: i128, wide: i128) -> Option<i128> {
    if wide >= cycle || place.rem_euclid(cycle) < wide {
        return Some(0);
    }
    let low = (-place).rem_euclid(cycle);
    first_between(step.rem_euclid(cycle), cycle, low, low + wide - 1)
}

/// The least k >= 0 with `low <= (k * step) mod cycle <= high`, for
/// `0 < low <= high < cycle`. Each round divides as Euclid does.
fn first_between(step: i128, cycle: i128, low: i128, high: i128) -> Option<i128> {
    if step == 0 {
        return None;
    }
    // The other way round where that is the shorter way, or Euclid is slow.
    if 2 * step > cycle {
        return first_between(cycle - step, cycle, cycle - high, cycle - low);
    }
    let first = (low + step - 1).div_euclid(step);
    if first * step <= high {
        return Some(first);
    }
    // None without a wrap: how many wraps are needed is the same question, one
    // step of Euclid further: `k * step - wraps * cycle` is to be in the range.
    let wraps =
        first_between((-cycle).rem_euclid(step), step, low.rem_euclid(step), high.rem_euclid(step));
    let wraps = wraps?;
    Some((low + wraps * cycle + step - 1).div_euclid(step))
}

fn least_common_multiple(a: u64, b: u64) -> Option<u64> {
    (a / greatest_common_divisor(a, b)).checked_mul(b)
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn routine(first: u64, interval: u64, length: u64) -> Routine {
        Routine { phase: Phase { first, interval }, length }
    }

    /// By trying every occurrence of two whole patterns.
    fn tried(a: Routine, b: Routine) -> Option<u64> {
        let last = a.phase.first.max(b.phase.first) + 2 * a.phase.interval * b.phase.interval;
        let runs = |task: Routine| {
            (0..)
                .map(move |k| task.phase.first + k * task.phase.interval)
                .take_while(move |due| *due <= last)
                .map(move |due| (due, due + task.length))
        };
        let overlaps = runs(a).flat_map(|(from, until)| {
            runs(b)
                .filter(move |(start, end)| *start < until && *end > from)
                .map(move |(start, _)| start.max(from))
        });
        overlaps.min()
    }

    #[test]
    fn two_that_start_together_collide_at_once_and_at_the_common_multiple() {
        let meeting = meeting(routine(0, 60, 5), routine(0, 90, 5));
        assert_eq!(meeting, Some(Meeting { first: 0, every: Some(180) }));
    }

    #[test]
    fn two_that_run_in_each_other_s_gaps_never_collide() {
        assert_eq!(meeting(routine(0, 60, 30), routine(30, 60, 30)), None);
        assert!(meeting(routine(0, 60, 31), routine(30, 60, 30)).is_some());
    }

    #[test]
    fn who_takes_no_time_meets_nobody() {
        assert_eq!(meeting(routine(0, 60, 0), routine(0, 60, 30)), None);
    }

    #[test]
    fn a_task_that_begins_years_later_is_met_then() {
        let (a, b) = (routine(0, 60, 1), routine(1_000_000_000_000_000, 7, 1));
        let first = meeting(a, b).map(|meeting| meeting.first);
        assert!(first.is_some_and(|first| (0..=420).contains(&(first - 1_000_000_000_000_000))));
    }

    #[test]
    fn intervals_without_a_common_multiple_in_range_have_none() {
        let (a, b) = (routine(0, NEVER - 1, 1), routine(0, NEVER - 3, 1));
        assert_eq!(meeting(a, b), Some(Meeting { first: 0, every: None }));
        assert_eq!(meeting(a, routine(0, u64::MAX, 1)), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        #[test]
        fn arithmetic_finds_what_trying_finds(
            (first_a, first_b) in (0_u64..120, 0_u64..120),
            (every_a, every_b) in (1_u64..40, 1_u64..40),
            (long_a, long_b) in (1_u64..40, 1_u64..40),
        ) {
            let a = routine(first_a, every_a, long_a.min(every_a));
            let b = routine(first_b, every_b, long_b.min(every_b));
            prop_assert_eq!(meeting(a, b).map(|meeting| meeting.first), tried(a, b));
        }
    }
}
