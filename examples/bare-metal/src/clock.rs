//! The clock port, over a counter of 32 bits.

use core::cell::Cell;

use critical_section::Mutex;
use faregate_tickets::clock::{Clock, Instant};

use crate::sys;

/// The board's clock.
#[derive(Debug)]
pub(crate) struct BoardClock {
    latest: Mutex<Cell<Instant>>,
}

/// The only one: gates and broker must agree about the time.
pub(crate) static CLOCK: BoardClock = BoardClock { latest: Mutex::new(Cell::new(Instant::START)) };

impl Clock for BoardClock {
    /// The counter runs over every 71 minutes. Whoever reads it counts that, so
    /// it must be read once in that time; the sensors see to it.
    fn now(&self) -> Instant {
        critical_section::with(|masked| {
            let latest = self.latest.borrow(masked);
            let before = latest.get().as_micros();
            let [.., a, b, c, d] = before.to_be_bytes();
            let passed = sys::microseconds().wrapping_sub(u32::from_be_bytes([a, b, c, d]));
            let now = Instant::from_micros(before.saturating_add(passed.into()));
            latest.set(now);
            now
        })
    }
}
