//! Limits on commands: how many, and how close together.

use super::{Denial, Rule};
use crate::clock::{Duration, Instant};

/// So many commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Invocations {
    left: u32,
}

impl Invocations {
    pub(super) const fn new(n: u32) -> Self {
        Self { left: n }
    }

    pub(super) fn check(&self) -> Result<(), Denial> {
        if self.left > 0 {
            return Ok(());
        }
        Err(Denial { rule: Rule::Invocations, short_by: 1, until: None })
    }

    pub(super) fn commit(&mut self) {
        self.left = self.left.saturating_sub(1);
    }
}

/// One command per period, with bursts: the generic cell rate algorithm.
///
/// It keeps one instant instead of a count of tokens, so that nothing has to be
/// divided by the period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Rate {
    period: Duration,
    /// How far the schedule may run ahead of the clock.
    tolerance: Duration,
    /// When the next command would be due if all came one period apart.
    due: Instant,
}

impl Rate {
    pub(super) const fn new(burst: u32, period: Duration) -> Self {
        match burst.checked_sub(1) {
            Some(ahead) => {
                Self { period, tolerance: period.saturating_mul(ahead as u64), due: Instant::START }
            }
            None => Self { period, tolerance: Duration::ZERO, due: Instant::FAR_FUTURE },
        }
    }

    pub(super) fn check(&self, now: Instant) -> Result<(), Denial> {
        let ahead = self.due.since(now);
        if self.due == Instant::FAR_FUTURE {
            // No clock comes to its end, however large the tolerance.
            return Err(Denial { rule: Rule::Rate, short_by: ahead.as_micros(), until: None });
        }
        let wait = ahead.saturating_sub(self.tolerance);
        too_soon(wait, now, Rule::Rate)
    }

    pub(super) fn commit(&mut self, now: Instant) {
        self.due = self.due.max(now).after(self.period);
    }
}

/// The last command at least so long ago.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Separation {
    min: Duration,
    next: Instant,
}

impl Separation {
    pub(super) const fn new(min: Duration) -> Self {
        Self { min, next: Instant::START }
    }

    pub(super) fn check(&self, now: Instant) -> Result<(), Denial> {
        too_soon(self.next.since(now), now, Rule::Separation)
    }

    pub(super) fn commit(&mut self, now: Instant) {
        self.next = self.next.max(now.after(self.min));
    }
}

fn too_soon(wait: Duration, now: Instant, rule: Rule) -> Result<(), Denial> {
    if wait.is_zero() {
        return Ok(());
    }
    Err(Denial { rule, short_by: wait.as_micros(), until: Some(now.after(wait)) })
}
