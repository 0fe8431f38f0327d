//! Wake-ups over a condition variable, for hosts without `eventfd`.
//!
//! The bell's mutex has no priority inheritance: a notifier can wait for a
//! waiter that was pre-empted while it held it. Linux does better.

use std::io;
use std::sync::{Condvar, Mutex, PoisonError};

use faregate_tickets::clock::{Clock, Instant};

use super::Woken;
use crate::clock::MonotonicClock;

/// A bell that any thread may ring and one thread at a time waits for.
///
/// The bell remembers: a notification that comes before the wait ends the next
/// wait at once, so none is lost between looking for work and going to sleep.
/// It does not count: notifications that nobody took meanwhile are one. Where
/// two threads wait, one of them takes it.
#[derive(Debug)]
pub struct Wakeup {
    rung: Mutex<bool>,
    bell: Condvar,
    clock: MonotonicClock,
}

impl Wakeup {
    /// A bell that has not been rung.
    ///
    /// # Errors
    /// None on this host.
    pub fn new() -> io::Result<Self> {
        Ok(Self { rung: Mutex::new(false), bell: Condvar::new(), clock: MonotonicClock::new() })
    }

    /// Ends the wait, or the next one if nobody waits.
    pub fn notify(&self) {
        // A `bool` cannot be torn, so a poisoned mutex is as good as another.
        *self.rung.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.bell.notify_one();
    }

    /// Sleeps until somebody notifies, or until `deadline` by the
    /// [`MonotonicClock`]; without one as long as it takes. A notification
    /// that is there already wins over a deadline that has passed.
    ///
    /// # Errors
    /// None on this host.
    pub fn wait_until(&self, deadline: Option<Instant>) -> io::Result<Woken> {
        let mut rung = self.rung.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if std::mem::take(&mut *rung) {
                return Ok(Woken::Notified);
            }
            rung = match deadline.map(|deadline| deadline.since(self.clock.now())) {
                None => self.bell.wait(rung).unwrap_or_else(PoisonError::into_inner),
                Some(rest) if rest.is_zero() => return Ok(Woken::Deadline),
                Some(rest) => {
                    let waited = self.bell.wait_timeout(rung, rest.into());
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }
}
