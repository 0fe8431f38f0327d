//! Time is an argument: instants, durations, and the port that gives them.
//!
//! Both are whole microseconds in 64 bits (584 000 years), saturating, so no
//! arithmetic on them can panic or wrap.

use core::fmt;

/// A length of time, in microseconds. People are shown as much of it as they
/// can use:
///
/// ```
/// use faregate_tickets::clock::Duration;
///
/// let shown = |us| Duration::from_micros(us).to_string();
/// assert_eq!([shown(9_999), shown(10_000), shown(999_999)], ["9999 us", "10.0 ms", "999.9 ms"]);
/// assert_eq!([shown(1_000_000), shown(2_500_000), shown(90_125_000)], ["1 s", "2.5 s", "90.125 s"]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Duration(u64);

impl Duration {
    /// No time at all.
    pub const ZERO: Self = Self(0);
    /// Longer than any mission.
    pub const MAX: Self = Self(u64::MAX);

    /// So many microseconds.
    #[must_use]
    pub const fn from_micros(us: u64) -> Self {
        Self(us)
    }

    /// So many milliseconds.
    #[must_use]
    pub const fn from_millis(ms: u64) -> Self {
        Self(ms.saturating_mul(1_000))
    }

    /// So many seconds.
    #[must_use]
    pub const fn from_secs(s: u64) -> Self {
        Self(s.saturating_mul(1_000_000))
    }

    /// The number of whole microseconds.
    #[must_use]
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// Whether this is no time at all.
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.0 == 0
    }

    /// The sum, or [`Duration::MAX`].
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// The difference, or no time where `other` is the longer.
    #[must_use]
    pub const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }

    /// So many times as long, or [`Duration::MAX`].
    #[must_use]
    pub const fn saturating_mul(self, times: u64) -> Self {
        Self(self.0.saturating_mul(times))
    }
}

impl From<core::time::Duration> for Duration {
    /// Rounded down to whole microseconds, and no longer than [`Duration::MAX`].
    fn from(duration: core::time::Duration) -> Self {
        Self(u64::try_from(duration.as_micros()).unwrap_or(u64::MAX))
    }
}

impl From<Duration> for core::time::Duration {
    fn from(duration: Duration) -> Self {
        Self::from_micros(duration.0)
    }
}

impl fmt::Display for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            us if us < 10_000 => write!(f, "{us} us"),
            us if us < 1_000_000 => write!(f, "{}.{} ms", us / 1_000, us / 100 % 10),
            us => seconds(f, us / 1_000_000, us / 1_000 % 1_000),
        }
    }
}

/// As people write them: `3 s`, `2.5 s`, `1.125 s`.
fn seconds(f: &mut fmt::Formatter<'_>, whole: u64, thousandths: u64) -> fmt::Result {
    match thousandths {
        0 => write!(f, "{whole} s"),
        of if of % 100 == 0 => write!(f, "{whole}.{} s", of / 100),
        of if of % 10 == 0 => write!(f, "{whole}.{:02} s", of / 10),
        of => write!(f, "{whole}.{of:03} s"),
    }
}

/// A point in time, in microseconds since the clock's own start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Instant(u64);

impl Instant {
    /// The clock's own start.
    pub const START: Self = Self(0);
    /// Later than any mission.
    pub const FAR_FUTURE: Self = Self(u64::MAX);

    /// So many microseconds after the start.
    #[must_use]
    pub const fn from_micros(us: u64) -> Self {
        Self(us)
    }

    /// Microseconds since the start.
    #[must_use]
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// The instant `duration` later, or [`Instant::FAR_FUTURE`].
    #[must_use]
    pub const fn after(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(duration.0))
    }

    /// The time from `earlier` until this instant; none where `earlier` is
    /// the later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Duration {
        Duration(self.0.saturating_sub(earlier.0))
    }
}

impl fmt::Display for Instant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:06} s", self.0 / 1_000_000, self.0 % 1_000_000)
    }
}

/// The clock port.
///
/// A gate owns its clock and reads it inside its critical section: a holder
/// cannot bring its own time. A clock may stand still; one that goes backwards
/// is survived (the gate does not go back with it) and recorded.
///
/// # Timing
/// `now` runs inside the critical section of every command: implement it
/// without loops, locks or allocation.
pub trait Clock: Send {
    /// The present instant.
    fn now(&self) -> Instant;
}

impl<C: Clock + Sync + ?Sized> Clock for &C {
    fn now(&self) -> Instant {
        (**self).now()
    }
}
