//! Points in time on either clock, as signed microseconds.
//!
//! Signed, because a task may have been accepted before this manager started.

use crate::time::{Duration, Instant, Now, UnixTime};

/// Microseconds on one of the clocks.
pub(crate) type Micros = i64;

/// Which clock a time is told by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Clock {
    /// The one that never jumps.
    Elapsed,
    /// The time of day.
    Wall,
}

/// A point in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Point {
    pub(crate) clock: Clock,
    pub(crate) at: Micros,
}

impl Point {
    pub(crate) const fn elapsed(at: Micros) -> Self {
        Self { clock: Clock::Elapsed, at }
    }

    pub(crate) const fn wall(at: Micros) -> Self {
        Self { clock: Clock::Wall, at }
    }

    pub(crate) const fn plus(self, micros: Micros) -> Self {
        Self { clock: self.clock, at: self.at.saturating_add(micros) }
    }
}

/// The present, by both clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Present {
    pub(crate) elapsed: Micros,
    pub(crate) wall: Micros,
}

impl Present {
    pub(crate) const fn by(self, clock: Clock) -> Micros {
        match clock {
            Clock::Elapsed => self.elapsed,
            Clock::Wall => self.wall,
        }
    }

    pub(crate) const fn has_reached(self, point: Point) -> bool {
        point.at <= self.by(point.clock)
    }

    /// How far ahead the point is; negative when it has passed.
    pub(crate) const fn until(self, point: Point) -> Micros {
        point.at.saturating_sub(self.by(point.clock))
    }

    /// The point on the clock that never jumps, as the two clocks stand now.
    pub(crate) const fn on_elapsed(self, point: Point) -> Micros {
        self.elapsed.saturating_add(self.until(point))
    }
}

impl From<Now> for Present {
    fn from(now: Now) -> Self {
        Self { elapsed: from_instant(now.elapsed), wall: now.wall.as_micros() }
    }
}

pub(crate) fn from_instant(instant: Instant) -> Micros {
    Micros::try_from(instant.as_micros()).unwrap_or(Micros::MAX)
}

pub(crate) fn from_duration(duration: Duration) -> Micros {
    Micros::try_from(duration.as_micros()).unwrap_or(Micros::MAX)
}

/// A time before the manager's own start is its start.
pub(crate) fn to_instant(at: Micros) -> Instant {
    Instant::from_micros(u64::try_from(at).unwrap_or(0))
}

pub(crate) fn to_wall(at: Micros) -> UnixTime {
    UnixTime::from_micros(at)
}
