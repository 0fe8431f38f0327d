//! The device: a register, and one call that stores into it.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use faregate::prelude::*;

/// A device's register. A relaxed store compiles to the plain store that a
/// volatile one does, and needs no `unsafe`; no compiler merges them either.
#[derive(Debug, Default)]
pub(crate) struct Register(AtomicU32);

impl Register {
    /// One that lives as long as the bench, as hardware does.
    pub(crate) fn installed() -> &'static Self {
        Box::leak(Box::default())
    }

    /// The command, as a call: what every entrant issues, whoever guards it.
    #[inline(never)]
    pub(crate) fn command(&self, value: u32) {
        self.0.store(value, Relaxed);
    }

    /// The command, as one store.
    #[inline(always)]
    pub(crate) fn store(&self, value: u32) {
        self.0.store(value, Relaxed);
    }
}

/// The site whose driver lets its gate do the store.
pub(crate) const ONE_STORE: u8 = 3;

/// The driver of a register. It draws nothing, so its tickets need no lease.
///
/// Each `SITE` is a device of its own to the compiler, whose tickets are invoked
/// in one place, as in a program with one holder: it can decide there whether to
/// inline, as it can for the peers.
#[derive(Debug)]
pub(crate) struct Driver<const SITE: u8>(pub(crate) &'static Register);

impl<const SITE: u8> Device for Driver<SITE> {
    type Command = u32;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        // A shared machine may stop this thread for many times the millisecond
        // of a command, inside of it too. That is not the driver's fault.
        Profile { overrun_factor: u8::MAX, ..Profile::new() }
    }

    fn declare(_: &u32) -> Declaration {
        Declaration { code: 1, wcet: Duration::from_millis(1), effect: Effect::Unchanged }
    }

    fn issue(&mut self, command: u32) -> Result<(), ()> {
        self.0.command(command);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }

    fn register(&self) -> Option<&'static AtomicU32> {
        (SITE == ONE_STORE).then_some(&self.0.0)
    }

    fn word(command: &u32) -> Option<(u32, ())> {
        (SITE == ONE_STORE).then_some((*command, ()))
    }
}
