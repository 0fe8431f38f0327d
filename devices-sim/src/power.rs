//! Supplies that trip.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};

/// A supply that trips when more is drawn than it can give, for longer than its
/// trip time.
#[derive(Clone, Debug)]
pub(crate) struct Supply {
    trip_time: Duration,
    overdrawn_since: Option<Instant>,
}

impl Supply {
    pub(crate) fn new(trip_time: Duration) -> Self {
        Self { trip_time, overdrawn_since: None }
    }

    /// Sees the draw and the supply as they are from now on.
    pub(crate) fn see(&mut self, now: Instant, draw: Milliwatts, supply: Milliwatts) {
        let overdrawn = draw > supply;
        self.overdrawn_since = self.overdrawn_since.or(Some(now)).filter(|_| overdrawn);
    }

    /// When it trips, if everything stays as it is: one tick after its time, so
    /// that a draw that ends on time does not trip it.
    pub(crate) fn trips_at(&self) -> Option<Instant> {
        let bears_until = self.overdrawn_since?.after(self.trip_time);
        Some(bears_until.after(Duration::from_micros(1)))
    }
}
