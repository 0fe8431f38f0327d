//! A device whose hardware is a closure of the model, and what it stands on.

use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::lock::{LoomLocked, Strategy};
use faregate_tickets::platform::{Containment, Panicked, Platform};
use faregate_tickets::recorder::NoLane;

/// What the models stand on; their gates are entered by `S`.
#[derive(Debug)]
pub(crate) struct Loomed<S = LoomLocked>(PhantomData<S>);

impl<S: Strategy> Platform for Loomed<S> {
    type Strategy = S;
    type Clock = &'static Ticks;
    type Lane = NoLane;
    type Containment = Contained;
}

/// A clock that moves on whenever somebody reads it. Not loom's: a reading adds
/// no behaviour to a model, and no reading is ever equal to another.
#[derive(Debug, Default)]
pub(crate) struct Ticks(AtomicU64);

impl Clock for Ticks {
    fn now(&self) -> Instant {
        Instant::from_micros(self.0.fetch_add(1, Ordering::Relaxed))
    }
}

/// Keeps a death inside a driver from the thread that called it. Anything else
/// that unwinds is a failed claim, and goes on.
#[derive(Debug)]
pub(crate) struct Contained;

/// What a driver that dies unwinds with.
struct Death;

impl Containment for Contained {
    fn contain<R>(f: impl FnOnce() -> R) -> Result<R, Panicked> {
        catch_unwind(AssertUnwindSafe(f))
            .map_err(|reason| if reason.is::<Death>() { Panicked } else { resume_unwind(reason) })
    }
}

/// A command of the lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    On,
    Off,
    /// Changes nothing that the books must know.
    Turn(u32),
    Die,
}

/// What reaches the hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Given {
    On,
    Off,
    Turned,
    Safe,
}

/// A driver, with the hardware that the model wants.
pub(crate) struct Lamp {
    watts: u32,
    /// Where `Turn` is one store.
    register: Option<&'static AtomicU32>,
    hardware: Box<dyn FnMut(Given) + Send>,
}

impl Lamp {
    pub(crate) fn new(watts: u32, hardware: impl FnMut(Given) + Send + 'static) -> Self {
        Self { watts, register: None, hardware: Box::new(hardware) }
    }

    /// The same lamp, with a register.
    pub(crate) fn with(self, register: &'static AtomicU32) -> Self {
        Self { register: Some(register), ..self }
    }
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new().drawing(Milliwatts::from_watts(self.watts))
    }

    fn declare(command: &Switch) -> Declaration {
        let effect = match command {
            Switch::On | Switch::Die => Effect::on(Milliwatts::from_watts(1)),
            Switch::Off => Effect::Off,
            Switch::Turn(_) => Effect::Unchanged,
        };
        Declaration { code: 0, wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, command: Switch) -> Result<(), ()> {
        match command {
            Switch::On => (self.hardware)(Given::On),
            Switch::Off => (self.hardware)(Given::Off),
            Switch::Turn(to) => {
                (self.hardware)(Given::Turned);
                if let Some(register) = self.register {
                    register.store(to, Ordering::Relaxed);
                }
            }
            Switch::Die => {
                (self.hardware)(Given::On);
                resume_unwind(Box::new(Death));
            }
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        (self.hardware)(Given::Safe);
        Ok(())
    }

    fn register(&self) -> Option<&'static AtomicU32> {
        self.register
    }

    fn word(command: &Switch) -> Option<(u32, ())> {
        match *command {
            Switch::Turn(to) => Some((to, ())),
            Switch::On | Switch::Off | Switch::Die => None,
        }
    }
}
