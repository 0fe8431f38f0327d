//! Functions of the program itself, as tasks.

use core::fmt;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time;

use parking_lot::{Condvar, Mutex};

use crate::bodies::workers::{Call, WorkerId, Workers};
use crate::executive::{CommandRefused, Commands, Waker};
use crate::manager::{Attempt, Event, Exit, Stop};
use crate::port::Beat;
use crate::time::{Duration, Instant};

/// A function that a task can be. What it answers is how the task ends.
pub type Function = dyn Fn(&Invocation) -> Result<(), String> + Send + Sync;

/// The lowest number that a program can register a function under; those below
/// are the manager's own.
const FIRST: u16 = 16;

/// The functions that tasks can name, by SMAARTE's `type`.
#[derive(Clone, Default)]
pub struct Functions(BTreeMap<u16, Arc<Function>>);

/// Why a function was not registered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotRegistered {
    /// Numbers below 16 are the manager's own functions.
    Reserved(u16),
    /// Another function has this number.
    Used(u16),
}

impl fmt::Display for NotRegistered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reserved(number) => {
                write!(f, "type {number} is the manager's own: functions begin at {FIRST}")
            }
            Self::Used(number) => write!(f, "type {number} is another function already"),
        }
    }
}

impl core::error::Error for NotRegistered {}

impl Functions {
    /// None.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Has tasks of this type call `function`, on a worker thread.
    ///
    /// # Errors
    /// The number is not free.
    pub fn register(
        &mut self,
        number: u16,
        function: impl Fn(&Invocation) -> Result<(), String> + Send + Sync + 'static,
    ) -> Result<(), NotRegistered> {
        if number < FIRST {
            return Err(NotRegistered::Reserved(number));
        }
        if self.0.contains_key(&number) {
            return Err(NotRegistered::Used(number));
        }
        self.0.insert(number, Arc::new(function));
        Ok(())
    }

    /// The numbers that have a function.
    pub fn numbers(&self) -> impl Iterator<Item = u16> {
        self.0.keys().copied()
    }
}

impl fmt::Debug for Functions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.0.keys()).finish()
    }
}

/// What a function is given.
#[derive(Debug)]
pub struct Invocation {
    attempt: Attempt,
    arguments: Vec<String>,
    shared: Arc<Shared>,
    commands: CommandsOf,
    manager: Waker,
}

impl Invocation {
    /// Which attempt this is.
    #[must_use]
    pub fn attempt(&self) -> Attempt {
        self.attempt
    }

    /// What the schedule says.
    #[must_use]
    pub fn arguments(&self) -> &[String] {
        &self.arguments
    }

    /// Issues a command on the task's tickets.
    ///
    /// # Timing
    /// As long as the device takes.
    ///
    /// # Errors
    /// Why it was not issued.
    ///
    /// # After revocation
    /// Refused, and the refusal names the taker.
    pub fn command(
        &self,
        gate: &str,
        command: &str,
        arguments: &[String],
    ) -> Result<String, CommandRefused> {
        self.commands.0.command(self.attempt, gate, command, arguments)
    }

    /// Says that the function is alive, where the schedule wants to hear it.
    ///
    /// # Timing
    /// One atomic operation; a system call where the manager has heard the beat
    /// before. However often it beats, one beat waits to be heard.
    pub fn heartbeat(&self) {
        self.shared.beat.beat(|| self.manager.wake());
    }

    /// Whether the function is to save its work and return. Its commands are
    /// refused by then. After its grace it counts as runaway: its worker is
    /// lost, and its categories stay taken until it returns.
    #[must_use]
    pub fn asked_to_stop(&self) -> bool {
        *self.shared.asked.lock()
    }

    /// Waits for this long, or until the function is asked to stop. Answers
    /// whether it was.
    #[must_use]
    pub fn asked_to_stop_within(&self, duration: Duration) -> bool {
        let mut asked = self.shared.asked.lock();
        let wait = time::Duration::from(duration);
        self.shared.changed.wait_while_for(&mut asked, |asked| !*asked, wait);
        *asked
    }
}

/// What a function and the manager's thread share.
#[derive(Debug, Default)]
struct Shared {
    /// Whether the function was asked to stop.
    asked: Mutex<bool>,
    changed: Condvar,
    beat: Beat,
}

impl Shared {
    fn ask(&self) {
        *self.asked.lock() = true;
        self.changed.notify_all();
    }
}

struct CommandsOf(Arc<dyn Commands>);

impl fmt::Debug for CommandsOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Commands")
    }
}

/// The functions that run.
#[derive(Debug, Default)]
pub(super) struct Calls {
    functions: Functions,
    live: BTreeMap<Attempt, Running>,
}

#[derive(Debug)]
struct Running {
    worker: WorkerId,
    shared: Arc<Shared>,
    grace_ends: Option<Instant>,
}

impl Calls {
    pub(super) fn new(functions: Functions) -> Self {
        Self { functions, live: BTreeMap::new() }
    }

    /// # Errors
    /// Why it is not called, for people.
    pub(super) fn start(
        &mut self,
        attempt: Attempt,
        number: u16,
        arguments: &[String],
        workers: &mut Workers,
    ) -> Result<(), String> {
        let Some(function) = self.functions.0.get(&number) else {
            return Err(format!("no function is registered for type {number}"));
        };
        let shared = Arc::<Shared>::default();
        let invocation = Invocation {
            attempt,
            arguments: arguments.to_vec(),
            shared: Arc::clone(&shared),
            commands: CommandsOf(Arc::clone(workers.commands())),
            manager: workers.manager().clone(),
        };
        let worker = workers.give(Call::Function(Arc::clone(function), invocation))?;
        self.live.insert(attempt, Running { worker, shared, grace_ends: None });
        Ok(())
    }

    /// A function cannot be stopped from outside, only asked. One that was to
    /// be paused has no time at all for it.
    pub(super) fn stop(&mut self, attempt: Attempt, how: Stop, now: Instant) {
        let Some(running) = self.live.get_mut(&attempt) else { return };
        let grace = match how {
            Stop::Pause => Duration::ZERO,
            Stop::Checkpoint { grace, .. } | Stop::Kill { grace } => grace,
        };
        running.shared.ask();
        let ends = now.after(grace);
        running.grace_ends = Some(running.grace_ends.map_or(ends, |earlier| earlier.min(ends)));
    }

    /// It has returned.
    pub(super) fn returned(&mut self, attempt: Attempt, exit: Exit, events: &mut Vec<Event>) {
        if self.live.remove(&attempt).is_some() {
            events.push(Event::Exited { attempt, exit });
        }
    }

    /// Tells of heartbeats, and of those whose grace is over. To be called when
    /// all reports were heard.
    pub(super) fn poll(&mut self, now: Instant, workers: &mut Workers, events: &mut Vec<Event>) {
        for (attempt, running) in &mut self.live {
            if running.shared.beat.take() {
                events.push(Event::Heartbeat { attempt: *attempt });
            }
            if running.grace_ends.is_some_and(|ends| ends <= now) {
                // Told once. It has no worker to give back when it returns.
                running.grace_ends = None;
                workers.dismiss(running.worker);
                events.push(Event::Runaway { attempt: *attempt });
            }
        }
    }

    pub(super) fn next_due(&self) -> Option<Instant> {
        self.live.values().filter_map(|running| running.grace_ends).min()
    }
}

/// A manager that goes asks all its functions to stop, and waits for none.
impl Drop for Calls {
    fn drop(&mut self) {
        self.live.values().for_each(|running| running.shared.ask());
    }
}
