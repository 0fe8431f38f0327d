//! The sensors: a value goes in when it is measured, and comes out when it has
//! arrived, with noise.

use std::collections::VecDeque;

use faregate_tickets::clock::{Duration, Instant};

use crate::random::mix;
use crate::sensors::Measured;

/// A sensor of a number.
#[derive(Clone, Debug)]
pub(super) struct Gauge {
    noise: u64,
    seed: u64,
    on_its_way: VecDeque<Measured<i64>>,
    said: Option<Measured<i64>>,
}

impl Gauge {
    pub(super) fn new(noise: i64, seed: u64, number: u64) -> Self {
        Self {
            noise: noise.unsigned_abs(),
            seed: mix(seed ^ mix(number.wrapping_add(1))),
            on_its_way: VecDeque::new(),
            said: None,
        }
    }

    /// Measures. The noise is that of the instant: it does not depend on who
    /// asked before.
    pub(super) fn measure(&mut self, now: Instant, value: i64) {
        let spread = self.noise.saturating_mul(2).saturating_add(1);
        let thrown = mix(self.seed ^ now.as_micros()) % spread;
        let noise = i64::try_from(thrown).unwrap_or(0) - i64::try_from(self.noise).unwrap_or(0);
        self.on_its_way
            .push_back(Measured { value: value.saturating_add(noise), measured_at: now });
    }

    /// What was measured `lag` ago has arrived.
    pub(super) fn arrive(&mut self, now: Instant, lag: Duration) {
        while self.on_its_way.front().is_some_and(|one| one.measured_at.after(lag) <= now) {
            self.said = self.on_its_way.pop_front();
        }
    }

    /// What has not arrived is lost.
    pub(super) fn forget(&mut self) {
        self.on_its_way.clear();
    }

    pub(super) fn said(&self) -> Option<Measured<i64>> {
        self.said
    }
}
