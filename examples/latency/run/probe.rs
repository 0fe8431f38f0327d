//! A strategy that holds up one thread on its way into the gate, and has it
//! pre-empted once it is inside. To every other thread it is the strategy
//! within.

use std::cell::RefCell;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::AtomicU32;

use faregate::tickets::clock::Duration;
use faregate::tickets::lock::{Exclusion, Owner, Shut, Strategy, Task, Way};
use faregate::tickets::ticket::Seat;

use super::stage::Stage;

thread_local! {
    /// The stage on which the calling thread is held up.
    static STALLS: RefCell<Option<Arc<Stage>>> = const { RefCell::new(None) };
}

/// Has the calling thread held up on its way into the gate behind [`Probed`]
/// that it enters next, and pre-empted in the look that it takes inside.
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

/// A ticket's way into the lock of `S`, with a probe.
pub(crate) struct ProbedWay<W>(W);

impl<S: Strategy> Strategy for Probed<S> {
    type Lock<T: Send> = ProbedLock<S::Lock<T>>;
}

impl<T: Send, L: Exclusion<T>> Exclusion<T> for ProbedLock<L> {
    type Way<'l>
        = ProbedWay<L::Way<'l>>
    where
        Self: 'l;

    fn way<'l>(&'l self, seat: &Seat<'l>, patience: Duration) -> ProbedWay<L::Way<'l>> {
        ProbedWay(self.0.way(seat, patience))
    }

    fn new(value: T) -> Self {
        Self(L::new(value))
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        self.0.with(f)
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

impl<T, W: Way<T>> Way<T> for ProbedWay<W> {
    fn with<S, E, J: Task<T, S>>(
        &self,
        look: impl Fn() -> Result<S, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        if let Some(stage) = STALLS.with_borrow(Option::clone) {
            stage.stall();
        }
        let look = || {
            if let Some(stage) = STALLS.take() {
                stage.check_inside();
            }
            look()
        };
        self.0.with(look, task)
    }

    fn try_with<S, E, J: Task<T, S>>(
        &self,
        look: impl Fn() -> Result<S, E>,
        task: J,
    ) -> Result<Result<J::Output, E>, Shut> {
        self.0.try_with(look, task)
    }

    fn store(&self, register: &AtomicU32, word: u32) -> bool {
        self.0.store(register, word)
    }

    fn step_back(&self) {
        self.0.step_back();
    }
}
