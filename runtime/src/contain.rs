//! Containment: a driver's panic ends at its gate.

use std::any::Any;
use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind};

use faregate_tickets::platform::{Containment, Panicked};

/// Catches a driver's panic and gives it back as a value, so that it faults
/// the driver's gate and never reaches a rescuer's thread (*Source Death*).
///
/// The panic hook is left alone: it has run, on the panicking thread, before
/// anything is caught. In a program built with `panic = "abort"` nothing can
/// be caught, and a driver must not panic.
#[derive(Clone, Copy, Debug)]
pub struct Caught;

impl Containment for Caught {
    /// # Timing
    /// Free while nothing panics. A panic costs an allocation, the unwinding,
    /// and whatever the program's hook does (the standard one writes to
    /// `stderr`): a mission that needs a bound here sets its own hook.
    fn is_unwinding() -> bool {
        std::thread::panicking()
    }

    fn contain<R>(f: impl FnOnce() -> R) -> Result<R, Panicked> {
        // What `f` was changing may be torn. Nobody will look at it as if it
        // were whole: that is what `Panicked` tells the gate, which is faulted
        // until a supervisor resets it.
        catch_unwind(AssertUnwindSafe(f)).map_err(|payload| {
            discard(payload);
            Panicked
        })
    }
}

/// Drops what was thrown. Its `Drop` is the driver's code and may panic too;
/// what *that* throws is leaked, or there would be no end to it.
fn discard(payload: Box<dyn Any + Send>) {
    if let Err(thrown_by_drop) = catch_unwind(AssertUnwindSafe(|| drop(payload))) {
        let _ = ManuallyDrop::new(thrown_by_drop);
    }
}
