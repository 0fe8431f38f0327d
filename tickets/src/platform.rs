//! What a gate stands on: a lock, a clock, a recorder lane, a containment.

use crate::clock::Clock;
use crate::lock::Strategy;
use crate::recorder::Lane;

/// The ports of a gate or a broker, chosen together at compile time.
///
/// Any tuple `(strategy, clock, lane)` is a platform without containment.
pub trait Platform {
    /// How critical sections are entered.
    type Strategy: Strategy;
    /// Where time comes from.
    type Clock: Clock;
    /// Where records go.
    type Lane: Lane;
    /// What keeps a driver's panic away from the agent.
    type Containment: Containment;
}

impl<S: Strategy, C: Clock, L: Lane> Platform for (S, C, L) {
    type Strategy = S;
    type Clock = C;
    type Lane = L;
    type Containment = Uncontained;
}

/// The containment port: runs a driver and turns its panic into a value.
pub trait Containment {
    /// Runs `f`; says [`Panicked`] if it did not come to its end.
    ///
    /// # Errors
    /// [`Panicked`].
    fn contain<R>(f: impl FnOnce() -> R) -> Result<R, Panicked>;

    /// Whether the calling thread is unwinding: a ticket dropped then had a
    /// holder that died, and did not give it back of its own will.
    #[must_use]
    fn is_unwinding() -> bool {
        false
    }
}

/// No containment: a driver must not panic. If it does and the panic unwinds,
/// its gate is faulted on the way and the panic goes on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uncontained;

impl Containment for Uncontained {
    fn contain<R>(f: impl FnOnce() -> R) -> Result<R, Panicked> {
        Ok(f())
    }
}

/// A driver panicked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Panicked;
