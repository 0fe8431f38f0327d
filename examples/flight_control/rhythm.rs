//! Periodic threads: woken at absolute times, with their lateness counted.

use faregate::prelude::*;
use faregate_devices_sim::SimClock;

/// The cycles of one periodic thread. They begin at absolute times: a late one
/// does not put off the next. One that could begin only when the next is due is
/// left out, and counted as a slip.
pub(crate) struct Rhythm {
    clock: SimClock,
    pub(crate) period: Duration,
    next: Instant,
    until: Instant,
    /// How many cycles have begun.
    pub(crate) cycles: u64,
    /// How many were left out.
    pub(crate) slips: u64,
    /// How late the latest began.
    pub(crate) latest: Duration,
}

impl Rhythm {
    pub(crate) fn new(clock: &SimClock, period: Duration, until: Instant) -> Self {
        let (cycles, slips, latest) = (0, 0, Duration::ZERO);
        Self { clock: clock.clone(), period, next: clock.now(), until, cycles, slips, latest }
    }

    /// Waits until the next cycle begins; false when the flight is over.
    pub(crate) fn next_cycle(&mut self) -> bool {
        self.clock.wait_until(self.next);
        let now = self.clock.now();
        if now >= self.until {
            return false;
        }
        let late = now.since(self.next);
        let slipped = late.as_micros().checked_div(self.period.as_micros()).unwrap_or(0);
        self.next = self.next.after(self.period.saturating_mul(slipped + 1));
        self.cycles += 1;
        self.slips += slipped;
        self.latest = self.latest.max(late);
        true
    }
}
