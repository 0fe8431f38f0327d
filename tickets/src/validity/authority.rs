//! Limits on authority: who may command, and until when.

use super::{Ask, Denial, Rule};
use crate::clock::{Duration, Instant};
use crate::device::Effect;

/// From one instant on, and before another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Window {
    from: Instant,
    until: Instant,
}

impl Window {
    pub(super) const fn new(from: Instant, until: Instant) -> Self {
        Self { from, until }
    }

    pub(super) fn check(&self, now: Instant) -> Result<(), Denial> {
        still_before(self.until, now, Rule::Window)?;
        if now < self.from {
            let short_by = self.from.since(now).as_micros();
            return Err(Denial { rule: Rule::Window, short_by, until: Some(self.from) });
        }
        Ok(())
    }

    pub(super) const fn end(&self) -> Instant {
        self.until
    }

    pub(super) fn is_over(&self, now: Instant) -> bool {
        now >= self.until
    }
}

/// So long after the first On command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct TimeLimit {
    limit: Duration,
    /// Known from the first On command.
    end: Option<Instant>,
}

impl TimeLimit {
    pub(super) const fn new(limit: Duration) -> Self {
        Self { limit, end: None }
    }

    pub(super) fn check(&self, now: Instant) -> Result<(), Denial> {
        // A limit of no time at all is over before its first command.
        still_before(self.end.unwrap_or(now.after(self.limit)), now, Rule::TimeLimit)
    }

    pub(super) fn commit(&mut self, ask: &Ask<'_>) {
        if let (None, Effect::On { .. }) = (self.end, ask.effect) {
            self.end = Some(ask.now.after(self.limit));
        }
    }

    pub(super) const fn end(&self) -> Option<Instant> {
        self.end
    }

    pub(super) fn is_over(&self, now: Instant) -> bool {
        self.end.is_some_and(|end| now >= end)
    }
}

/// As long as the holder is heard of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Lease {
    period: Duration,
    /// The clock's start, and so over, until the ticket is admitted.
    end: Instant,
}

impl Lease {
    pub(super) const fn new(period: Duration) -> Self {
        Self { period, end: Instant::START }
    }

    pub(super) fn check(&self, now: Instant) -> Result<(), Denial> {
        still_before(self.end, now, Rule::Lease)
    }

    pub(super) fn start(&mut self, now: Instant) {
        self.end = now.after(self.period);
    }

    pub(super) fn renew(&mut self, now: Instant) {
        if !self.is_over(now) {
            // Where the clock went back, what was promised stays.
            self.end = self.end.max(now.after(self.period));
        }
    }

    pub(super) const fn period(&self) -> Duration {
        self.period
    }

    pub(super) const fn end(&self) -> Instant {
        self.end
    }

    pub(super) fn is_over(&self, now: Instant) -> bool {
        now >= self.end
    }
}

fn still_before(end: Instant, now: Instant, rule: Rule) -> Result<(), Denial> {
    if now < end {
        return Ok(());
    }
    Err(Denial { rule, short_by: now.since(end).as_micros(), until: None })
}
