//! Gates behind an interrupt mask.

use core::cell::RefCell;

use critical_section::Mutex;

use super::{Exclusion, Owner, Shut, Strategy};
use crate::clock::Duration;
use crate::ticket::Seat;

/// The `critical-section` of the target: on one core without an operating
/// system, interrupts are off while somebody is inside.
///
/// So nobody ever finds the lock [`Shut::Busy`] or [`Shut::TimedOut`]: when
/// another asks, nothing can be in flight. Where an implementation of
/// `critical-section` excludes other cores or threads, all three ways in wait
/// for them, without a deadline.
///
/// # Timing
/// Interrupts stay off for as long as the closure runs: the longest command of
/// a gate is latency of every interrupt.
#[derive(Debug)]
pub struct Masked;

impl Strategy for Masked {
    type Lock<T: Send> = MaskedCell<T>;
}

/// A value that is reached with interrupts off. The `RefCell` is what notices
/// re-entry: a mask can be put on twice.
#[derive(Debug)]
pub struct MaskedCell<T>(Mutex<RefCell<T>>);

impl<T: Send> Exclusion<T> for MaskedCell<T> {
    type Way<'l>
        = &'l Self
    where
        Self: 'l;

    fn way<'l>(&'l self, _: &Seat<'l>, _: Duration) -> &'l Self {
        self
    }

    fn new(value: T) -> Self {
        Self(Mutex::new(RefCell::new(value)))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        critical_section::with(|mask| {
            let mut value = self.0.borrow(mask).try_borrow_mut().map_err(|_| Shut::Reentered)?;
            Ok(f(&mut value))
        })
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.with(f)
    }

    fn with_until<R>(&self, _: Duration, f: impl FnOnce(&mut T, Owner) -> R) -> Result<R, Shut> {
        self.with(|value| f(value, Owner::Sound))
    }
}
