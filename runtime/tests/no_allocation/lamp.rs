//! A lamp that says whether it is on, and holds a command as long as it is told.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::SeqCst};

use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Effect, Profile};

/// What a lamp draws, and what there is.
pub(crate) const WATTS: Milliwatts = Milliwatts::from_watts(8);

/// What is true of a lamp.
#[derive(Debug, Default)]
pub(crate) struct Truth {
    pub(crate) on: AtomicBool,
    /// A command is inside, and stays until this is false.
    pub(crate) held: AtomicBool,
    pub(crate) level: AtomicU32,
}

pub(crate) struct Lamp(pub(crate) &'static Truth);

#[derive(Clone, Copy)]
pub(crate) enum Switch {
    On,
    Off,
    /// One store.
    Dim(u32),
    /// The driver faults.
    Fault,
    /// Stays inside until `held` is false again.
    Hold,
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        let mut profile = Profile::new().drawing(WATTS);
        profile.longest_command = Duration::from_secs(5);
        profile
    }

    fn declare(command: &Switch) -> Declaration {
        let (code, effect) = match command {
            Switch::On => (1, Effect::on(WATTS)),
            Switch::Off => (2, Effect::Off),
            Switch::Dim(_) => (3, Effect::Unchanged),
            Switch::Fault => (4, Effect::Unchanged),
            Switch::Hold => (5, Effect::Unchanged),
        };
        Declaration { code, wcet: Duration::from_secs(5), effect }
    }

    fn issue(&mut self, command: Switch) -> Result<(), ()> {
        match command {
            Switch::On => self.0.on.store(true, SeqCst),
            Switch::Off => self.0.on.store(false, SeqCst),
            Switch::Dim(level) => self.0.level.store(level, SeqCst),
            Switch::Fault => return Err(()),
            Switch::Hold => {
                self.0.held.store(true, SeqCst);
                while self.0.held.load(SeqCst) {
                    std::thread::yield_now();
                }
            }
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Switch::Off)
    }

    fn register(&self) -> Option<&'static AtomicU32> {
        Some(&self.0.level)
    }

    fn word(command: &Switch) -> Option<(u32, ())> {
        match command {
            Switch::Dim(level) => Some((*level, ())),
            _ => None,
        }
    }
}
