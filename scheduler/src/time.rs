//! Two clocks: one that never jumps, and the time of day.

use core::fmt;

pub use faregate_tickets::clock::{Duration, Instant};
use serde::{Deserialize, Serialize};

/// A point in the time of day: microseconds since 1970-01-01T00:00:00 UTC, as
/// the host's wall clock counts them.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub struct UnixTime(i64);

impl UnixTime {
    /// So many microseconds since 1970.
    #[must_use]
    pub const fn from_micros(us: i64) -> Self {
        Self(us)
    }

    /// So many seconds since 1970.
    #[must_use]
    pub const fn from_secs(s: i64) -> Self {
        Self(s.saturating_mul(1_000_000))
    }

    /// Microseconds since 1970.
    #[must_use]
    pub const fn as_micros(self) -> i64 {
        self.0
    }

    /// The time `duration` later.
    #[must_use]
    pub fn after(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(i64::try_from(duration.as_micros()).unwrap_or(i64::MAX)))
    }

    /// The time since `earlier`; none where `earlier` is the later.
    #[must_use]
    pub fn since(self, earlier: Self) -> Duration {
        Duration::from_micros(u64::try_from(self.0.saturating_sub(earlier.0)).unwrap_or(0))
    }
}

impl fmt::Display for UnixTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:06}", self.0.div_euclid(1_000_000), self.0.rem_euclid(1_000_000))
    }
}

/// The present, by both clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Now {
    /// Since the manager's own start: never jumps, counts while the host
    /// sleeps (`CLOCK_BOOTTIME`).
    pub elapsed: Instant,
    /// The time of day: jumps when it is set.
    pub wall: UnixTime,
}

/// When the manager wants to be called again, if nothing happens before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Due {
    /// At this instant of the clock that never jumps.
    pub elapsed: Option<Instant>,
    /// At this time of day, whenever that comes.
    pub wall: Option<UnixTime>,
}
