//! A flag that wakes: what an eventfd is to real threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use faregate_tickets::clock::Instant;

use super::body::{self, Waiting, block};
use super::core::{self, Cause};

/// A flag that one body raises and another waits for. Raised before the wait,
/// it is not lost; raised twice, it counts once. Clones are the same flag.
#[derive(Clone, Debug, Default)]
pub struct WakeFlag(Arc<AtomicBool>);

impl WakeFlag {
    /// A flag that is down.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Raises the flag and wakes who waits for it. Not a switch point.
    pub fn wake(&self) {
        self.0.store(true, Ordering::Release);
        core::with(|core| core.flagged(self.address()));
    }

    /// Waits until the flag is up, and takes it down; or until the deadline.
    /// Says whether it was up.
    ///
    /// # Panics
    /// Outside a body.
    pub fn wait_until(&self, deadline: Instant) -> bool {
        body::switch_point("wait for flag");
        loop {
            if self.0.swap(false, Ordering::Acquire) {
                return true;
            }
            if body::now() >= deadline
                || block(Cause::Flag(self.address()), deadline) == Waiting::Over
            {
                return false;
            }
        }
    }

    fn address(&self) -> usize {
        Arc::as_ptr(&self.0).addr()
    }
}
