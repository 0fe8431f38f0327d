//! The battery: what generation and draw leave, integrated exactly. A milliwatt
//! for a microsecond is a nanojoule, so whole numbers suffice.

use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Duration, Instant};

use crate::parameters::Parameters;

/// What the battery holds.
#[derive(Clone, Debug)]
pub(crate) struct Battery {
    stored_nj: u64,
    capacity_nj: u64,
    flat: bool,
}

impl Battery {
    pub(crate) fn new(parameters: &Parameters) -> Self {
        let nanojoules = |energy: Microjoules| energy.get().saturating_mul(1_000);
        let capacity_nj = nanojoules(parameters.battery_capacity);
        let stored_nj = nanojoules(parameters.battery_stored).min(capacity_nj);
        Self { stored_nj, capacity_nj, flat: false }
    }

    pub(crate) fn stored_nj(&self) -> u64 {
        self.stored_nj
    }

    /// Whether it cannot feed the present deficit for another microsecond.
    pub(crate) fn is_flat(&self) -> bool {
        self.flat
    }

    /// Sees the draw and the generation as they are from now on.
    pub(crate) fn see(&mut self, draw: Milliwatts, generation: Milliwatts) {
        self.flat = self.stored_nj < deficit(draw, generation);
    }

    /// When it is flat, if everything stays as it is.
    pub(crate) fn flat_at(
        &self,
        now: Instant,
        draw: Milliwatts,
        generation: Milliwatts,
    ) -> Option<Instant> {
        let left_us = self.stored_nj.checked_div(deficit(draw, generation))?;
        (!self.flat).then(|| now.after(Duration::from_micros(left_us)))
    }

    /// Loses so much at once.
    pub(crate) fn lose(&mut self, energy: Microjoules) {
        self.stored_nj = self.stored_nj.saturating_sub(energy.get().saturating_mul(1_000));
    }

    /// Lets time pass at this draw and generation. What a full battery cannot
    /// take is shunted; what a flat one cannot give is missing on the bus.
    pub(crate) fn pass(&mut self, time: Duration, draw: Milliwatts, generation: Milliwatts) {
        let us = time.as_micros();
        let charged = deficit(generation, draw).saturating_mul(us);
        self.stored_nj = self.stored_nj.saturating_add(charged).min(self.capacity_nj);
        if !self.flat {
            let drawn = deficit(draw, generation).saturating_mul(us);
            self.stored_nj = self.stored_nj.saturating_sub(drawn);
        }
    }
}

/// What `draw` needs beyond `generation`, in milliwatts.
fn deficit(draw: Milliwatts, generation: Milliwatts) -> u64 {
    draw.saturating_sub(generation).get()
}
