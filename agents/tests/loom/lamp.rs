//! A device whose hardware is a closure of the model, and what it stands on.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, Ordering};

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::lock::LoomLocked;
use faregate_tickets::platform::{Containment, Panicked, Platform};
use faregate_tickets::recorder::NoLane;

/// What the models stand on.
#[derive(Debug)]
pub(crate) struct Loomed;

impl Platform for Loomed {
    type Strategy = LoomLocked;
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
    Die,
}

/// What reaches the hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Given {
    On,
    Off,
    Safe,
}

/// A driver, with the hardware that the model wants.
pub(crate) struct Lamp {
    watts: u32,
    hardware: Box<dyn FnMut(Given) + Send>,
}

impl Lamp {
    pub(crate) fn new(watts: u32, hardware: impl FnMut(Given) + Send + 'static) -> Self {
        Self { watts, hardware: Box::new(hardware) }
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
        };
        Declaration { code: 0, wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, command: Switch) -> Result<(), ()> {
        match command {
            Switch::On => (self.hardware)(Given::On),
            Switch::Off => (self.hardware)(Given::Off),
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
}
