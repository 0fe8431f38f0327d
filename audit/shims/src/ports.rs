//! The ports that the entries stand on, each of them the least that there is.

use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Effect, Profile};
use faregate_tickets::lock::{Exclusion, Locked, Masked, Owner, Shut, Strategy};
use faregate_tickets::recorder::{Lane, NoLane, Record};

use crate::sys::Register;
use crate::sys::mutex::{OneExchange, OneThread};

/// What the valve's register was last told.
static REGISTER: Register<u32> = Register::new(0);
/// What the valve answers: anything but 0 is a fault.
pub(crate) static STATUS: Register<u32> = Register::new(0);
/// The time.
pub(crate) static NOW: Register<u64> = Register::new(0);

pub(crate) const DRAW: Milliwatts = Milliwatts::from_watts(8);

#[derive(Clone, Copy, Debug)]
pub(crate) enum Setting {
    Off,
    On,
    Same,
}

impl Setting {
    fn declare(self) -> Declaration {
        let effect = match self {
            Self::Off => Effect::Off,
            Self::On => Effect::on(DRAW),
            Self::Same => Effect::Unchanged,
        };
        Declaration { code: self as u16, wcet: Duration::from_millis(1), effect }
    }
}

/// A driver that is made when its gate is.
pub(crate) trait Bench:
    Device<Command = Setting, Response = (), Fault = ()> + 'static
{
    const NEW: Self;
}

/// A device whose commands are one store in a register.
#[derive(Debug)]
pub(crate) struct Valve(());

/// A device whose commands are one store, and which says whether it obeyed.
#[derive(Debug)]
pub(crate) struct Answering(());

impl Bench for Valve {
    const NEW: Self = Self(());
}

impl Bench for Answering {
    const NEW: Self = Self(());
}

impl Device for Valve {
    type Command = Setting;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new().drawing(DRAW)
    }

    fn declare(command: &Setting) -> Declaration {
        command.declare()
    }

    fn issue(&mut self, command: Setting) -> Result<(), ()> {
        REGISTER.write(command as u32);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Setting::Off)
    }
}

impl Device for Answering {
    type Command = Setting;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new().drawing(DRAW)
    }

    fn declare(command: &Setting) -> Declaration {
        command.declare()
    }

    fn issue(&mut self, command: Setting) -> Result<(), ()> {
        REGISTER.write(command as u32);
        if STATUS.read() == 0 { Ok(()) } else { Err(()) }
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Setting::Off)
    }
}

/// A clock that is one word.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Word;

impl Clock for Word {
    fn now(&self) -> Instant {
        Instant::from_micros(NOW.read())
    }
}

const RECORDS: usize = 8;

/// A lane that keeps the latest few records in a ring of its own.
#[derive(Debug)]
pub(crate) struct Ring {
    records: [Option<Record>; RECORDS],
    next: usize,
}

impl Default for Ring {
    fn default() -> Self {
        Self { records: [None; RECORDS], next: 0 }
    }
}

impl Lane for Ring {
    fn record(&mut self, record: Record) {
        // The mask changes nothing: it spares the check of the bounds.
        self.records[self.next & (RECORDS - 1)] = Some(record);
        self.next = self.next.wrapping_add(1) & (RECORDS - 1);
    }
}

/// A gate that its agent enters and no holder does: what is left of an
/// invocation then is all that a refused one costs.
#[derive(Debug)]
pub(crate) struct AgentOnly;

/// The value behind an [`AgentOnly`] gate.
#[derive(Debug)]
pub(crate) struct AgentOnlyLock<L>(L);

impl Strategy for AgentOnly {
    type Lock<T: Send> = AgentOnlyLock<<Masked as Strategy>::Lock<T>>;
}

impl<T, L: Exclusion<T>> Exclusion<T> for AgentOnlyLock<L> {
    fn new(value: T) -> Self {
        Self(L::new(value))
    }

    fn with<R>(&self, _: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        Err(Shut::Busy)
    }

    fn try_with<R>(&self, _: impl FnOnce(&mut T) -> R) -> Result<R, Shut> {
        Err(Shut::Busy)
    }

    fn with_until<R>(
        &self,
        timeout: Duration,
        f: impl FnOnce(&mut T, Owner) -> R,
    ) -> Result<R, Shut> {
        self.0.with_until(timeout, f)
    }
}

/// The default of Linux hosts.
#[cfg(target_os = "linux")]
pub(crate) type Pi<L = NoLane> =
    (faregate_tickets::lock::PiLocked<crate::sys::thread::TheThread>, Word, L);
/// The default of one core without an operating system.
pub(crate) type Bare<L = NoLane> = (Masked, Word, L);
/// The adapter for any `lock_api` mutex, over the least of them.
pub(crate) type Adapted<L = NoLane> = (Locked<OneExchange, OneThread>, Word, L);
/// Holders are refused.
pub(crate) type Refusing = (AgentOnly, Word, NoLane);
