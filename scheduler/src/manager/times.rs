//! When occurrences are due, and when their windows are open.

use crate::manager::entry::Entry;
use crate::manager::limits::LATENESS;
use crate::manager::point::{Micros, Point, Present, from_duration};
use crate::task::When;

/// A window of one occurrence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Open {
    pub(crate) from: Point,
    /// The last instant at which an attempt may start.
    pub(crate) until: Option<Point>,
}

impl Entry {
    /// Occurrence `number` is due: its first window opens. The phase is never
    /// shifted.
    pub(crate) fn due_of(&self, number: u64) -> Point {
        let opens = self.task.windows.first().map(|window| window.opens).unwrap_or_default();
        let shift = self.shift(number);
        self.point(opens, shift).unwrap_or(Point::elapsed(self.accepted.elapsed).plus(shift))
    }

    /// The last occurrence that is due by now, if one is.
    pub(crate) fn last_due_by(&self, now: Present) -> Option<u64> {
        let since = now.until(self.due_of(0)).checked_neg()?;
        let interval = from_duration(self.task.interval?).max(1);
        let times = u64::try_from(since.checked_div_euclid(interval)?).ok()?;
        Some(times.saturating_add(self.back))
    }

    /// The first window of the occurrence that is open; if none is, the one
    /// that opens next; if all have closed, none.
    pub(crate) fn window(&self, number: u64, now: Present) -> Option<Open> {
        let shift = self.shift(number);
        let windows = self.task.windows.iter().map(|window| Open {
            from: self.point(window.opens, shift).unwrap_or_else(|| self.due_of(number)),
            until: self.point(window.closes, shift),
        });
        let has_closed = |window: &Open| window.until.is_some_and(|at| now.until(at) < 0);
        windows
            .filter(|window| !has_closed(window))
            .min_by_key(|window| now.until(window.from).max(0))
    }

    /// The same for an attempt of the present occurrence. One that goes on with
    /// what was saved is no start: it needs no window.
    pub(crate) fn present_window(&self, now: Present) -> Option<Open> {
        if self.saved {
            return Some(Open { from: self.due, until: None });
        }
        self.window(self.current, now)
    }

    /// The first occurrence from this one on that may still start: not all of
    /// its windows have closed, and its cutoff has not come. Ends that are told
    /// by the time of day can lie any number of intervals before the others.
    pub(crate) fn first_possible(&self, from: u64, now: Present) -> u64 {
        let interval = self.task.interval.map_or(0, from_duration).max(1);
        let since = |end: Point| now.until(end).saturating_neg();
        // So many intervals later an end lies that has not passed.
        let intervals = |since: Micros| since.div_euclid(interval).saturating_add(1);
        let windows = self.task.windows.iter().map(|window| {
            let closes = self.point(window.closes, 0);
            closes.map_or(0, |end| intervals(since(end).saturating_sub(1)))
        });
        let cutoff = self.point(self.task.cutoff, 0);
        let cutoff = cutoff.map_or(0, |end| intervals(since(end)));
        let first = windows.min().unwrap_or(0).max(cutoff);
        from.max(u64::try_from(first).unwrap_or(0).saturating_add(self.back))
    }

    /// A window that opened since the last step and has closed already, within
    /// what a host may be late: the manager was, and not the task.
    pub(crate) fn late_window(&self, number: u64, last: Present, now: Present) -> Option<Open> {
        let shift = self.shift(number);
        let mut windows = self.task.windows.iter().map(|window| Open {
            from: self.point(window.opens, shift).unwrap_or_else(|| self.due_of(number)),
            until: self.point(window.closes, shift),
        });
        windows.find(|window| {
            let ago = now.until(window.from).saturating_neg();
            !last.has_reached(window.from) && (0..=from_duration(LATENESS)).contains(&ago)
        })
    }

    /// The latest end of an occurrence.
    pub(crate) fn cutoff_of(&self, number: u64) -> Option<Point> {
        self.point(self.task.cutoff, self.shift(number))
    }

    fn shift(&self, number: u64) -> Micros {
        let interval = self.task.interval.map_or(0, from_duration);
        let times = number.saturating_sub(self.back);
        interval.saturating_mul(Micros::try_from(times).unwrap_or(Micros::MAX))
    }

    /// How far back an occurrence is to be, where it would be due more than two
    /// intervals from now: then it is due at the first time after now that is in
    /// phase. None: it is due before, or at the very first time. A clock that is
    /// set right by less than an interval lets nothing come twice.
    pub(crate) fn back_for(&self, number: u64, now: Present) -> Option<u64> {
        let interval = from_duration(self.task.interval?).max(1);
        if now.until(self.due_of(number)) <= interval.saturating_mul(2) {
            return None;
        }
        let since = now.until(self.due_of(0)).saturating_neg();
        let times = if since < 0 { 0 } else { since.div_euclid(interval).saturating_add(1) };
        let back = number.checked_sub(u64::try_from(times).unwrap_or(0))?;
        (back > self.back).then_some(back)
    }

    fn point(&self, when: When, shift: Micros) -> Option<Point> {
        let point = match when {
            When::Unrestricted => return None,
            When::AfterLoad(after) => {
                Point::elapsed(self.accepted.elapsed).plus(from_duration(after))
            }
            When::At(time) => Point::wall(time.as_micros()),
        };
        Some(point.plus(shift))
    }
}
