//! A bell between two threads of a row.

use faregate::prelude::{Clock, Duration};
use faregate::runtime::clock::MonotonicClock;
use faregate::runtime::wake::{Wakeup, Woken};

use super::Outcome;

/// Longer than any round takes, hogs and outliers included.
const PATIENCE: Duration = Duration::from_secs(10);

/// A bell that remembers that it was rung.
#[derive(Debug)]
pub(crate) struct Bell(Wakeup);

impl Bell {
    pub(crate) fn new() -> Outcome<Self> {
        Ok(Self(Wakeup::new()?))
    }

    /// Where the waiter is more important than the caller and on its CPU, it
    /// runs before this returns.
    pub(crate) fn ring(&self) {
        self.0.notify();
    }

    pub(crate) fn wait(&self) -> Outcome<()> {
        let deadline = MonotonicClock::new().now().after(PATIENCE);
        match self.0.wait_until(Some(deadline))? {
            Woken::Notified => Ok(()),
            Woken::Deadline => Err("another thread of the row did not come".into()),
        }
    }
}
