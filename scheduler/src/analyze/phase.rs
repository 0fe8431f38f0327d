//! When a task is due, from what the schedule says.

use crate::task::{Task, When};
use crate::time::{Duration, UnixTime};

/// From the load, in microseconds; negative: before it.
pub(super) type Offset = i128;

/// Where a point in time is, seen from a load at this time of day.
pub(super) fn offset(when: When, load: UnixTime) -> Option<Offset> {
    match when {
        When::Unrestricted => None,
        When::AfterLoad(after) => Some(after.as_micros().into()),
        When::At(at) => Some(Offset::from(at.as_micros()) - Offset::from(load.as_micros())),
    }
}

/// Where a task's occurrence 0 is due; without a start time that is the load.
pub(super) fn base(task: &Task, load: UnixTime) -> Offset {
    task.windows.first().and_then(|window| offset(window.opens, load)).unwrap_or(0)
}

/// The number of the first occurrence that can run: one that is past counts
/// while one of its windows is open.
pub(super) fn first_number(task: &Task, load: UnixTime) -> u64 {
    let base = base(task, load);
    let Some(interval) = interval(task).filter(|_| base < 0) else { return 0 };
    let last = (-base).div_euclid(interval);
    let due = base + last * interval;
    let is_open = task.windows.iter().any(|window| {
        offset(window.closes, load).is_none_or(|closes| closes + last * interval >= 0)
    });
    let number = if due == 0 || is_open { last } else { last + 1 };
    u64::try_from(number).unwrap_or(u64::MAX)
}

fn interval(task: &Task) -> Option<Offset> {
    task.interval.map(|interval| interval.as_micros().into()).filter(|interval| *interval > 0)
}

/// A routine task's phase: from the load on, it is due at `first + k * interval`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Phase {
    pub(super) first: u64,
    pub(super) interval: u64,
}

/// The phase of a routine task; none: it is not one.
pub(super) fn phase(task: &Task, load: UnixTime) -> Option<Phase> {
    let interval = interval(task)?;
    let base = base(task, load);
    let first = if base < 0 { base.rem_euclid(interval) } else { base };
    Some(Phase { first: u64::try_from(first).ok()?, interval: u64::try_from(interval).ok()? })
}

/// A time from the load on: what is before it is 0.
pub(super) fn from_load(offset: Offset) -> Duration {
    Duration::from_micros(u64::try_from(offset.max(0)).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::{Body, TaskId, Window};

    /// Every 60 s since 1000 s of the time of day, each time until 10 s later.
    fn each_minute() -> Task {
        let mut task = Task::new(TaskId::new(1).unwrap(), Body::Hold);
        let at = |s| When::At(UnixTime::from_secs(s));
        task.windows = vec![Window { opens: at(1000), closes: at(1010) }];
        task.interval = Some(Duration::from_secs(60));
        task
    }

    fn seconds(phase: Phase) -> (u64, u64) {
        (phase.first / 1_000_000, phase.interval / 1_000_000)
    }

    #[test]
    fn a_routine_task_keeps_the_phase_that_it_had_before_the_load() {
        for (load, number, first) in [(900, 0, 100), (1000, 0, 0), (1030, 1, 30), (1070, 1, 50)] {
            let load = UnixTime::from_secs(load);
            assert_eq!(first_number(&each_minute(), load), number, "{load}");
            assert_eq!(phase(&each_minute(), load).map(seconds), Some((first, 60)), "{load}");
        }
    }

    #[test]
    fn an_occurrence_whose_window_has_closed_is_not_the_first() {
        assert_eq!(first_number(&each_minute(), UnixTime::from_secs(1071)), 2);
    }
}
