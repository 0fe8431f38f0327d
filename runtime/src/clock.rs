//! The host's monotonic clock.

use faregate_tickets::clock::{Clock, Instant};
use rustix::time::{ClockId, Timespec, clock_gettime};

/// `CLOCK_MONOTONIC`, in microseconds since the host's own start.
///
/// All values of this type are the same clock, in every process of the host:
/// an instant read through one may be compared with another's. The clock never
/// goes back and never jumps with the time of day; where a host suspends, it
/// stands still meanwhile.
#[derive(Clone, Copy, Debug)]
pub struct MonotonicClock {
    /// Keeps [`MonotonicClock::new`] the only maker.
    _warm: (),
}

impl MonotonicClock {
    /// The clock, read once, so that the way to it (the vDSO) is not looked up
    /// inside somebody's first critical section.
    #[must_use]
    pub fn new() -> Self {
        let clock = Self { _warm: () };
        clock.now();
        clock
    }
}

impl Default for MonotonicClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for MonotonicClock {
    /// The present instant, rounded down.
    ///
    /// # Timing
    /// No system call where the kernel offers the clock in its vDSO, which
    /// reads again only while the kernel is updating the time. Where the
    /// host's time source cannot be read from user space (some virtual
    /// machines), one system call.
    fn now(&self) -> Instant {
        instant(clock_gettime(ClockId::Monotonic))
    }
}

/// The kernel never gives a negative monotonic time; if it did, that would be
/// the start.
fn instant(time: Timespec) -> Instant {
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let nanoseconds = u64::try_from(time.tv_nsec).unwrap_or(0);
    Instant::from_micros(seconds.saturating_mul(1_000_000).saturating_add(nanoseconds / 1_000))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(tv_sec: i64, tv_nsec: i64) -> Instant {
        instant(Timespec { tv_sec, tv_nsec })
    }

    #[test]
    fn instants_are_whole_microseconds_rounded_down() {
        assert_eq!(at(3, 14_999), Instant::from_micros(3_000_014));
        assert_eq!(at(0, 999), Instant::START);
    }

    #[test]
    fn no_time_of_the_kernel_overflows() {
        assert_eq!(at(i64::MAX, 999_999_999), Instant::FAR_FUTURE);
        assert_eq!(at(-1, -1), Instant::START);
    }

    #[test]
    fn two_clocks_are_one() {
        let (one, other) = (MonotonicClock::new(), MonotonicClock::new());
        let readings = [one.now(), other.now(), one.now(), other.now()];
        assert!(readings.is_sorted(), "{readings:?}");
        assert!(readings[0] > Instant::START);
    }
}
