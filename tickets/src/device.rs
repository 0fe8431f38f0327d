//! The device port: commands as typed values, and what is declared of them.

use core::sync::atomic::AtomicU32;

use crate::amount::{MilligramsPerSecond, Milliwatts};
use crate::clock::{Duration, Instant};

/// A driver for one command group of one device.
///
/// The driver is moved into its [`Gate`](crate::Gate) and must be the only
/// handle to its hardware: its author answers for that. What the compiler can
/// say about it, it says: a type that is `Clone` cannot implement `Device`,
/// because everything `Clone` already does, without any command.
///
/// Commands of one gate reach the device in order, and none overtakes a later
/// safing; where a bus queues them, [`drain`](Device::drain) empties the queue.
///
/// A driver never calls tickets or agents. Without a
/// [containment](crate::Containment) it must not panic.
pub trait Device: Send {
    /// The command set, as values: plain data that means the same whenever it
    /// is looked at. One with a reference, a cell or an atomic inside could be
    /// declared as one thing and issued as another.
    type Command: Copy;
    /// What a command answers.
    type Response;
    /// How the driver says that it could not do its work. A fault closes the
    /// gate until a supervisor resets it.
    type Fault;

    /// What is declared of the device as a whole. Read once, when its gate is
    /// made.
    fn profile(&self) -> Profile;

    /// What is declared of one command.
    ///
    /// # Timing
    /// Runs inside the critical section: a `match` over constants.
    fn declare(command: &Self::Command) -> Declaration;

    /// Gives the command to the hardware.
    ///
    /// # Errors
    /// The driver's own fault, when the hardware did not take the command.
    fn issue(&mut self, command: Self::Command) -> Result<Self::Response, Self::Fault>;

    /// Issues the safing command: it frees the device's draw, and leaves the
    /// *effect* alone where the mission needs it (a cutoff valve's coil goes
    /// off, the valve stays shut).
    ///
    /// # Errors
    /// The driver's own fault, when the hardware did not take the command.
    fn safe(&mut self) -> Result<(), Self::Fault>;

    /// The register to which some commands are one store, where the device has
    /// one. Asked for once, when its gate is made. A gate of
    /// [`Restartable`](crate::lock::Restartable) then does these stores itself.
    ///
    /// Like the driver, it must be the only way to its hardware.
    fn register(&self) -> Option<&'static AtomicU32> {
        None
    }

    /// What the command stores in the [`register`](Device::register) and what
    /// it answers, if that is all it does. Only a command whose effect is
    /// [`Effect::Unchanged`] can be no more than its store.
    ///
    /// # Timing
    /// A `match` over constants; [`issue`](Device::issue) does the same store.
    fn word(command: &Self::Command) -> Option<(u32, Self::Response)> {
        let _ = command;
        None
    }

    /// Waits until every command given so far has reached the device. Safing
    /// does this first. Devices without a queue leave it as it is.
    ///
    /// # Errors
    /// The driver's own fault, when the queue could not be emptied.
    fn drain(&mut self) -> Result<(), Self::Fault> {
        Ok(())
    }
}

/// What makes a cloneable driver a compile error: whoever implements
/// [`Device`] for a type that is `Clone` conflicts with this implementation,
/// which has no commands at all.
impl<T: Clone + Send> Device for T {
    type Command = core::convert::Infallible;
    type Response = core::convert::Infallible;
    type Fault = core::convert::Infallible;

    fn profile(&self) -> Profile {
        Profile::new()
    }

    fn declare(command: &Self::Command) -> Declaration {
        match *command {}
    }

    fn issue(&mut self, command: Self::Command) -> Result<Self::Response, Self::Fault> {
        match command {}
    }

    fn safe(&mut self) -> Result<(), Self::Fault> {
        Ok(())
    }
}

/// What a command does to the device's consumption.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Effect {
    /// Nothing.
    Unchanged,
    /// The device is on from now, and draws this much.
    On {
        /// Electrical draw while on.
        draw: Milliwatts,
        /// Propellant flow while on.
        flow: MilligramsPerSecond,
    },
    /// The device goes off. Whether it did is for the sensors to say.
    Off,
}

impl Effect {
    /// On, with this draw and no flow of propellant.
    #[must_use]
    pub const fn on(draw: Milliwatts) -> Self {
        Self::On { draw, flow: MilligramsPerSecond::ZERO }
    }
}

/// What is declared of one command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Declaration {
    /// The command's number in the flight recorder.
    pub code: u16,
    /// The longest time that issuing it takes.
    pub wcet: Duration,
    /// What it does to the device's consumption.
    pub effect: Effect,
}

/// What is declared of a device: its largest draw and its longest times, from
/// which the bound of a hand-over is computed.
///
/// Built up from [`Profile::new`], which declares a device without draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Profile {
    /// The largest draw of anything its commands can turn on, inrush included.
    /// This is what is charged.
    pub draw: Milliwatts,
    /// The largest flow of propellant.
    pub flow: MilligramsPerSecond,
    /// The longest time of any command.
    pub longest_command: Duration,
    /// The longest time of draining and safing together.
    pub longest_safing: Duration,
    /// How long after any command the device is what it was told to be, turning
    /// on included. A measurement counts only from then on.
    pub settling: Duration,
    /// How long after settling a state estimate measured then has arrived.
    pub estimate_lag: Duration,
    /// How often safing is tried before the device counts as stuck; at least
    /// once.
    pub safing_attempts: u8,
    /// A command that takes this many times its declared time makes the gate
    /// faulted; at least one.
    pub overrun_factor: u8,
    /// What happens when the device may be on and nobody holds a ticket for it.
    pub when_orphaned: WhenOrphaned,
    /// The lease of a ticket that names none. A device without draw needs none.
    /// [`Duration::MAX`] is none: for what cannot outlive its holder anyway.
    pub lease: Duration,
}

impl Profile {
    /// A device without draw, whose commands take at most a millisecond.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            draw: Milliwatts::ZERO,
            flow: MilligramsPerSecond::ZERO,
            longest_command: Duration::from_millis(1),
            longest_safing: Duration::from_millis(1),
            settling: Duration::ZERO,
            estimate_lag: Duration::from_millis(100),
            safing_attempts: 3,
            overrun_factor: 4,
            when_orphaned: WhenOrphaned::KeepUntilNeeded,
            lease: Duration::from_secs(1),
        }
    }

    /// How long a command or safing in progress is waited for. After it the
    /// gate is faulted.
    #[must_use]
    pub const fn patience(&self) -> Duration {
        let command = self.longest_command.as_micros();
        let safing = self.longest_safing.as_micros();
        let longest = if command > safing { command } else { safing };
        let factor = if self.overrun_factor == 0 { 1 } else { self.overrun_factor };
        Duration::from_micros(longest).saturating_mul(factor as u64)
    }

    /// The same with this largest draw.
    #[must_use]
    pub const fn drawing(mut self, draw: Milliwatts) -> Self {
        self.draw = draw;
        self
    }
}

impl Default for Profile {
    fn default() -> Self {
        Self::new()
    }
}

/// What happens to an orphaned device before its margin is needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WhenOrphaned {
    /// It stays as it is until somebody needs what it draws.
    #[default]
    KeepUntilNeeded,
    /// It is made safe at once.
    SafeAtOnce,
    /// It is made safe as soon as nobody has it, its holder included: when its
    /// ticket was revoked and nobody has taken the device over, or before
    /// anybody has got it.
    SafeUnlessHeld,
}

/// What the sensors say about a device, and when they measured it. Not what it
/// was told to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Estimate {
    /// What was measured.
    pub state: Power,
    /// When it was measured, by the broker's clock; not when it arrived.
    pub measured_at: Instant,
}

/// A device's measured power state. `Unknown` counts as on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Power {
    /// It draws nothing.
    Off,
    /// It draws something.
    On,
    /// The sensors cannot say.
    Unknown,
}
