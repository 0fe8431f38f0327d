//! A deterministic interleaver: threads of control as coroutines, one real
//! thread, virtual time, and a seed that decides who runs when.
//!
//! A body gives others the chance to run at its *switch points*: where it says
//! so ([`switch_point`]), where it waits, at every [`SimLock`], and in every
//! command of a simulated driver. Between switch points it runs alone. Time
//! moves only when everybody waits, to the earliest instant anybody waits for.
//!
//! ```
//! use faregate_devices_sim::SimClock;
//! use faregate_devices_sim::interleave::{self, Interleaver, Over};
//! use faregate_tickets::clock::Instant;
//! use faregate_tickets::id::Priority;
//!
//! let clock = SimClock::virtual_time();
//! let mut threads = Interleaver::new(&clock, 7);
//! for name in ["monitor", "emergency"] {
//!     threads.spawn(name, Priority::SCIENCE, || {
//!         interleave::wait_until(Instant::from_micros(20));
//!     });
//! }
//! let report = threads.run(Instant::from_micros(1_000));
//! assert_eq!(report.over, Over::Finished);
//! assert_eq!(report.at, Instant::from_micros(20));
//! ```

use std::any::Any;
use std::fmt;
use std::mem::ManuallyDrop;
use std::panic::resume_unwind;
use std::ptr::NonNull;

use faregate_tickets::clock::{Clock, Instant};
use faregate_tickets::id::Priority;
use generator::{Generator, Gn};

mod body;
mod core;
mod flag;
mod lock;
mod report;
mod schedule;

pub use body::{
    block_on, block_on_until, die, is_running, name, now, stop, switch_point, wait, wait_until,
};
pub use flag::WakeFlag;
pub use lock::{SimLock, SimLocked};
pub use report::{End, Over, Report, Switch};
pub use schedule::Schedule;

use self::body::{Abandoned, Death};
use self::core::{Body, Core, Next, State};
use crate::clock::SimClock;

/// Room for the deepest call tree of a debug build; untouched pages cost
/// nothing.
const STACK_BYTES: usize = 256 * 1024;

/// Threads of control about to be run together. See the
/// [module](crate::interleave).
///
/// Bodies may borrow what outlives the interleaver.
pub struct Interleaver<'env> {
    clock: SimClock,
    seed: u64,
    schedule: Schedule,
    log: bool,
    bodies: Vec<Body>,
    coroutines: Vec<Generator<'env, (), ()>>,
}

impl<'env> Interleaver<'env> {
    /// An interleaver that moves this clock. The seed gives the
    /// [schedule](Schedule::from_seed) and every choice.
    #[must_use]
    pub fn new(clock: &SimClock, seed: u64) -> Self {
        Self {
            clock: clock.clone(),
            seed,
            schedule: Schedule::from_seed(seed),
            log: false,
            bodies: Vec::new(),
            coroutines: Vec::new(),
        }
    }

    /// With this schedule instead of the seed's.
    #[must_use]
    pub fn schedule(mut self, schedule: Schedule) -> Self {
        self.schedule = schedule;
        self
    }

    /// With a log of all switch points in the report.
    #[must_use]
    pub fn log(mut self) -> Self {
        self.log = true;
        self
    }

    /// Adds a thread of control. Its priority matters to
    /// [`Schedule::Priorities`] alone.
    pub fn spawn(
        &mut self,
        name: &'static str,
        priority: Priority,
        body: impl FnOnce() + Send + 'env,
    ) {
        let mut coroutine = Gn::<()>::new_opt(STACK_BYTES / size_of::<usize>(), body);
        // Marks it as a coroutine: it may switch from any depth, and its panic
        // is kept for us. The pointer is never followed.
        coroutine.set_local_data(NonNull::dangling().as_ptr());
        self.coroutines.push(coroutine);
        self.bodies.push(Body::new(name, priority));
    }

    /// Runs the bodies until the last one ends, until `horizon`, until one
    /// calls [`stop`], or until none can go on. Those that are left are
    /// unwound, silently: what they own is dropped, what they locked is
    /// unlocked, and no time passes.
    ///
    /// # Panics
    /// If a body panicked, with its panic; the other bodies are unwound first.
    /// If called inside a body.
    pub fn run(mut self, horizon: Instant) -> Report {
        let mut core = Core::new(
            self.clock.clone(),
            std::mem::take(&mut self.bodies),
            self.schedule,
            self.seed,
            horizon,
        );
        core.log = self.log.then(Vec::new);
        core::open(core);
        let outcome = self.play();
        self.abandon();
        self.free_stacks();
        let core = core::close().expect("the books stay open for the whole run");
        match outcome {
            Ok(over) => report(core, over),
            Err(panic) => resume_unwind(panic),
        }
    }

    /// Lets bodies run until it is over; or until one panics.
    fn play(&mut self) -> Result<Over, Box<dyn Any + Send>> {
        loop {
            let next = core::with(Core::next_step).expect("the books are open");
            match next {
                Next::Over(over) => return Ok(over),
                Next::Resume(i) => self.resume(i)?,
            }
        }
    }

    /// Enters body `i` until it switches or ends.
    fn resume(&mut self, i: usize) -> Result<(), Box<dyn Any + Send>> {
        core::with(|core| {
            core.running = Some(i);
            core.resumes += 1;
            core.bodies[i].begun = true;
            core.bodies[i].state = State::Ready;
        });
        self.coroutines[i].resume();
        let done = self.coroutines[i].is_done();
        let panic = self.coroutines[i].get_panic_data().filter(|_| done);
        let end = match &panic {
            None => End::Finished,
            Some(panic) if panic.is::<Death>() => End::Died,
            Some(_) => End::Abandoned,
        };
        core::with(|core| {
            core.running = None;
            if done {
                core.progress += 1;
                core.bodies[i].state = State::Ended;
                core.bodies[i].end = end;
            }
        });
        match panic {
            Some(panic) if !panic.is::<Death>() && !panic.is::<Abandoned>() => Err(panic),
            _ => Ok(()),
        }
    }

    /// Unwinds every body that has begun and not ended. Those that were
    /// unwinding anyway come first; then one at a time, so that whether this
    /// thread unwinds says whether the body does.
    fn abandon(&mut self) {
        core::with(|core| core.abandoning = true);
        let mid_unwind = |i: &usize| core::with(|core| core.bodies[*i].mid_unwind) == Some(true);
        let (first, rest): (Vec<_>, Vec<_>) = (0..self.coroutines.len()).partition(mid_unwind);
        for i in first.into_iter().chain(rest) {
            if !self.unwind(i, 0) {
                core::with(|core| core.bodies[i].end = End::Leaked);
            }
        }
    }

    /// Unwinds body `i`, and before it whoever holds a lock that its
    /// destructors need; false if that comes to no end.
    fn unwind(&mut self, i: usize, depth: usize) -> bool {
        let mid_unwind = core::with(|core| core.bodies[i].mid_unwind) == Some(true);
        if depth == 0 && !mid_unwind && std::thread::panicking() {
            // A leaked body is half unwound. To unwind another one on top of it
            // would be to guess.
            return self.coroutines[i].is_done();
        }
        for _ in 0..self.coroutines.len() + 2 {
            if self.coroutines[i].is_done() || self.not_begun(i) {
                return true;
            }
            // A panic on the way out does not count: the first one is reported.
            let _ = self.resume(i);
            if let Some(holder) = core::with(|core| core.holder_before(i)).flatten()
                && (holder == i || depth > self.coroutines.len() || !self.unwind(holder, depth + 1))
            {
                return false;
            }
        }
        self.coroutines[i].is_done()
    }

    /// Frees the stacks of the bodies that ended or never began. One that would
    /// not unwind keeps its stack: what it owns and what it locked stay so.
    fn free_stacks(&mut self) {
        for (i, coroutine) in self.coroutines.drain(..).enumerate() {
            if core::with(|core| core.bodies[i].end) == Some(End::Leaked) {
                let _leaked = ManuallyDrop::new(coroutine);
            }
        }
    }

    fn not_begun(&self, i: usize) -> bool {
        core::with(|core| !core.bodies[i].begun) == Some(true)
    }
}

impl fmt::Debug for Interleaver<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Interleaver")
            .field("seed", &self.seed)
            .field("schedule", &self.schedule)
            .field("bodies", &self.bodies.iter().map(|body| body.name).collect::<Vec<_>>())
            .finish_non_exhaustive()
    }
}

fn report(core: Core, over: Over) -> Report {
    Report {
        over,
        at: core.clock.now(),
        ends: core.bodies.iter().map(|body| (body.name, body.end)).collect(),
        choices: core.choices,
        resumes: core.resumes,
        fingerprint: core.fingerprint,
        log: core.log.unwrap_or_default(),
    }
}
