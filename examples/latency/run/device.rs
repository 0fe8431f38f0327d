//! The device behind our gates, and its commands.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};

use faregate::prelude::{Declaration, Device, Duration, Effect, Profile};

use super::stage::Stage;

/// Longer than any hog works: how long a command takes is what is measured
/// here, and not the driver's fault.
pub(crate) const PATIENCE: Duration = Duration::from_secs(4);

/// The device of commands that are one store. Rows are played one after the
/// other, so that each has it alone.
pub(crate) static REGISTER: AtomicU32 = AtomicU32::new(0);

/// A command.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Order {
    /// One store of this number.
    Store(u32),
    /// The holder is pre-empted inside it.
    BePreempted,
}

/// The driver.
pub(crate) struct Driver(pub(crate) Arc<Stage>);

impl Device for Driver {
    type Command = Order;
    type Response = ();
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        let mut profile = Profile::new();
        profile.longest_command = PATIENCE;
        profile
    }

    fn declare(_: &Order) -> Declaration {
        Declaration { code: 1, wcet: PATIENCE, effect: Effect::Unchanged }
    }

    fn issue(&mut self, order: Order) -> Result<(), Infallible> {
        match order {
            Order::Store(number) => REGISTER.store(number, SeqCst),
            Order::BePreempted => self.0.command_inside(),
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
