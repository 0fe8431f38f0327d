//! A strategy that holds up one thread on its way into the gate, and has it
//! pre-empted once it is inside. To every other thread it is the strategy
//! within.

use std::cell::RefCell;
use std::marker::PhantomData;
use std::sync::Arc;

use faregate::tickets::clock::Duration;
use faregate::tickets::lock::{Exclusion, Owner, Shut, Strategy};

use super::stage::Stage;

thread_local! {
    /// The stage on which the calling thread is held up.
    static STALLS: RefCell<Option<Arc<Stage>>> = const { RefCell::new(None) };
}

/// Has the calling thread held up in the next critical section that it enters
/// behind [`Probed`].
pub(crate) fn stalling<R>(stage: &Arc<Stage>, f: impl FnOnce() -> R) -> R {
    STALLS.set(Some(Arc::clone(stage)));
    let result = f();
    STALLS.take();
    result
}

/// The strategy `S`, with a probe.
pub(crate) struct Probed<S>(PhantomData<S>);

/// The lock of `S`, with a probe.
pub(crate) struct ProbedLock<L>(L);

impl<S: Strategy> Strategy for Probed<S> {
    type Lock<T: Send> = ProbedLock<S::Lock<T>>;
}

impl<T, L: Exclusion<T>> Exclusion<T> for ProbedLock<L> {
    fn new(value: T) -> Self {
        Self(L::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        let Some(stage) = STALLS.take() else { return self.0.with(f) };
        stage.stall();
        self.0.with(|value| {
            stage.check_inside();
            f(value)
        })
    }

    fn try_with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.0.try_with(f)
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        self.0.with_until(timeout, f)
    }
}
