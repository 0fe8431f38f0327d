//! What a body can do. Reached through a thread-local: a driver deep inside a
//! gate has no handle to the interleaver.

use std::panic::resume_unwind;
use std::thread::panicking;

use faregate_tickets::clock::{Clock, Duration, Instant};

use super::core::{self, Cause};

/// The payload with which a body unwinds that died.
pub(super) struct Death;

/// The payload with which a body unwinds when the run is over without it.
pub(super) struct Abandoned;

/// Whether the caller is a body of an interleaver.
#[must_use]
pub fn is_running() -> bool {
    core::with(|core| core.running.is_some()) == Some(true)
}

/// The running body's name, if the caller is one.
#[must_use]
pub fn name() -> Option<&'static str> {
    core::with(|core| core.running.map(|i| core.bodies[i].name)).flatten()
}

/// The virtual time of the run.
///
/// # Panics
/// Outside a body.
#[must_use]
pub fn now() -> Instant {
    core::with(|core| core.clock.now()).expect("asked for the time of a run outside a body")
}

/// Here somebody else may run. Does nothing outside a body, nor while the body
/// unwinds.
pub fn switch_point(what: &'static str) {
    if panicking() {
        return;
    }
    match core::with(|core| core.running.is_none() || (!core.abandoning && core.goes_on(what))) {
        None | Some(true) => {}
        Some(false) if is_abandoned() => throw_abandoned(),
        Some(false) => {
            core::with(core::Core::progressed);
            switch();
        }
    }
}

/// Waits until `instant`. One that has passed is a switch point.
///
/// # Panics
/// Outside a body.
pub fn wait_until(instant: Instant) {
    switch_point("wait");
    while now() < instant {
        if block(Cause::Time, instant) == Waiting::Over {
            return;
        }
    }
}

/// Waits so long.
///
/// # Panics
/// Outside a body.
pub fn wait(duration: Duration) {
    wait_until(now().after(duration));
}

/// Waits until the condition holds, looking again whenever anybody else has
/// done anything or time has passed.
///
/// # Panics
/// Outside a body.
pub fn block_on(condition: impl FnMut() -> bool) {
    block_on_until(Instant::FAR_FUTURE, condition);
}

/// Waits until the condition holds, or until the deadline; says whether it
/// holds.
///
/// # Panics
/// Outside a body.
pub fn block_on_until(deadline: Instant, mut condition: impl FnMut() -> bool) -> bool {
    switch_point("block_on");
    // Looking is no progress: two bodies that look at each other must let time
    // pass. What this one did before is.
    core::with(core::Core::progressed);
    core::with(|core| core.set_polling(true));
    let holds = loop {
        // Read before the look: what happens during it is a reason to look
        // again.
        let seen = core::with(|core| core.progress).unwrap_or(0);
        if condition() {
            break true;
        }
        if now() >= deadline || block(Cause::Progress(seen), deadline) == Waiting::Over {
            break false;
        }
    };
    core::with(|core| core.set_polling(false));
    holds
}

/// Ends the run: the scenario is decided.
pub fn stop() {
    core::with(|core| core.stopped = true);
    switch_point("stop");
}

/// The running body dies: it unwinds without a message, and its report says
/// [`End::Died`](super::End::Died).
pub fn die() -> ! {
    resume_unwind(Box::new(Death))
}

/// What became of a wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Waiting {
    /// Look again at what was waited for.
    Again,
    /// The run is over: nothing will come.
    Over,
}

/// Puts the running body to sleep.
///
/// # Panics
/// Outside a body.
pub(super) fn block(cause: Cause, until: Instant) -> Waiting {
    assert!(is_running(), "a wait in virtual time outside a body: nobody could end it");
    if is_abandoned() {
        return block_abandoned(cause);
    }
    core::with(|core| core.block(cause, until));
    switch();
    if is_abandoned() && !matches!(cause, Cause::Lock { .. }) {
        Waiting::Over
    } else {
        Waiting::Again
    }
}

/// A wait of an unwinding body after the run is over. (One that caught its
/// unwinding was thrown at again by the switch point before this.) Locks are still waited for, because exclusion
/// must hold to the end; all other waits are over at once.
fn block_abandoned(cause: Cause) -> Waiting {
    if matches!(cause, Cause::Lock { .. }) {
        core::with(|core| core.block(cause, Instant::FAR_FUTURE));
        generator::co_yield_with(());
        return Waiting::Again;
    }
    while core::with(core::Core::spend_grace) == Some(false) {
        generator::co_yield_with(());
    }
    Waiting::Over
}

/// Gives the run's loop its turn.
fn switch() {
    let mid_unwind = core::with(|core| core.suspend(panicking())) == Some(true);
    generator::co_yield_with(());
    let over = core::with(|core| core.resumed()) == Some(true);
    if over && !mid_unwind {
        throw_abandoned();
    }
}

fn is_abandoned() -> bool {
    core::with(|core| core.abandoning) == Some(true)
}

/// Unwinds the body; without the panic hook, so nothing is printed.
fn throw_abandoned() -> ! {
    resume_unwind(Box::new(Abandoned))
}
