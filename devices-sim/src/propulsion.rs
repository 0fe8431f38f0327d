//! Tank and rigid body: what an open thruster takes from the one and does to
//! the other.

use faregate_tickets::amount::MilligramsPerSecond;
use faregate_tickets::clock::{Duration, Instant};

use crate::parameters::{Parameters, THRUSTER_FLOW};

/// Propellant. A milligram per second for a microsecond is a nanogram.
#[derive(Clone, Debug)]
pub(crate) struct Tank {
    left_ng: u64,
}

impl Tank {
    pub(crate) fn new(parameters: &Parameters) -> Self {
        Self { left_ng: parameters.propellant.get().saturating_mul(1_000_000) }
    }

    pub(crate) fn left_ng(&self) -> u64 {
        self.left_ng
    }

    /// Whether it cannot feed a thruster for another microsecond.
    pub(crate) fn is_empty(&self) -> bool {
        self.left_ng < THRUSTER_FLOW.get()
    }

    pub(crate) fn empty_at(&self, now: Instant, flow: MilligramsPerSecond) -> Option<Instant> {
        let left_us = self.left_ng.checked_div(flow.get())?;
        Some(now.after(Duration::from_micros(left_us)))
    }

    pub(crate) fn pass(&mut self, time: Duration, flow: MilligramsPerSecond) {
        let taken = flow.get().saturating_mul(time.as_micros());
        self.left_ng = self.left_ng.saturating_sub(taken);
    }
}

/// The spacecraft as a rigid body about one axis. A microradian per second
/// squared for a microsecond is a picoradian per second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Spin {
    rate_prad_s: u64,
    acceleration_urad_s2: u64,
    unrecoverable_prad_s: u64,
}

impl Spin {
    pub(crate) fn new(parameters: &Parameters) -> Self {
        Self {
            rate_prad_s: 0,
            acceleration_urad_s2: 0,
            unrecoverable_prad_s: u64::from(parameters.unrecoverable_rate_urad_s) * 1_000_000,
        }
    }

    pub(crate) fn rate_urad_s(&self) -> u64 {
        self.rate_prad_s / 1_000_000
    }

    /// Sees whether the thruster pushes from now on.
    pub(crate) fn see(&mut self, pushes: bool, parameters: &Parameters) {
        let acceleration = parameters.thruster_torque_unm.checked_div(parameters.inertia_kgm2);
        self.acceleration_urad_s2 = u64::from(acceleration.filter(|_| pushes).unwrap_or(0));
    }

    pub(crate) fn pass(&mut self, time: Duration) {
        let gained = self.acceleration_urad_s2.saturating_mul(time.as_micros());
        self.rate_prad_s = self.rate_prad_s.saturating_add(gained);
    }

    /// The same, so much later.
    pub(crate) fn later(mut self, time: Duration) -> Self {
        self.pass(time);
        self
    }

    pub(crate) fn is_unrecoverable(&self) -> bool {
        self.rate_prad_s >= self.unrecoverable_prad_s
    }

    pub(crate) fn unrecoverable_at(&self, now: Instant) -> Option<Instant> {
        if self.acceleration_urad_s2 == 0 {
            return None;
        }
        let missing = self.unrecoverable_prad_s.saturating_sub(self.rate_prad_s);
        Some(now.after(Duration::from_micros(missing.div_ceil(self.acceleration_urad_s2))))
    }
}
