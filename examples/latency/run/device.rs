//! The device behind our gates, and its commands.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::SeqCst};

use faregate::prelude::{Declaration, Device, Duration, Effect, Profile};

use super::stage::Stage;

/// What commands are declared to take at most. By then the hog would have
/// ended.
const LONGEST: Duration = Duration::from_millis(5);

/// How many times as long a command may take before it is the driver's fault,
/// and who waits for it gives up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Patience {
    /// Longer than hogs and hosts take: how long it is is what is measured.
    Long,
    /// For who waits without lending its priority, on one CPU for ever.
    Short,
}

impl Patience {
    const fn overrun_factor(self) -> u8 {
        match self {
            Self::Long => 200,
            Self::Short => 1,
        }
    }

    /// As long as that.
    pub(crate) const fn duration(self) -> Duration {
        LONGEST.saturating_mul(self.overrun_factor() as u64)
    }
}

/// The device of commands that are one store. Rows are played one after the
/// other, so that each has it alone.
pub(crate) static REGISTER: AtomicU32 = AtomicU32::new(0);

/// How many of these stores were called back, where the gate can do that.
pub(crate) static CALLED_BACK: AtomicU64 = AtomicU64::new(0);

/// A command.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Order {
    /// One store of this number.
    Store(u32),
    /// The same in a way that no gate can do itself.
    StoreInSteps(u32),
    /// The holder is pre-empted inside it.
    BePreempted,
}

/// The driver.
pub(crate) struct Driver {
    pub(crate) stage: Arc<Stage>,
    pub(crate) patience: Patience,
}

impl Device for Driver {
    type Command = Order;
    type Response = ();
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        let mut profile = Profile::new();
        profile.longest_command = LONGEST;
        profile.overrun_factor = self.patience.overrun_factor();
        profile
    }

    fn declare(_: &Order) -> Declaration {
        Declaration { code: 1, wcet: LONGEST, effect: Effect::Unchanged }
    }

    fn issue(&mut self, order: Order) -> Result<(), Infallible> {
        match order {
            Order::Store(number) | Order::StoreInSteps(number) => REGISTER.store(number, SeqCst),
            Order::BePreempted => self.stage.command_inside(),
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn register(&self) -> Option<&'static AtomicU32> {
        Some(&REGISTER)
    }

    fn word(order: &Order) -> Option<(u32, ())> {
        match order {
            Order::Store(number) => Some((*number, ())),
            Order::StoreInSteps(_) | Order::BePreempted => None,
        }
    }
}
