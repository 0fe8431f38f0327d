//! Lamps: drivers that do, or suffer, what the test says.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

use faregate_tickets::amount::{MilligramsPerSecond, Milliwatts};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Device, Effect, Profile};

/// What is true of a lamp, whatever anybody thinks.
#[derive(Debug, Default)]
pub(crate) struct Truth {
    pub(crate) on: AtomicBool,
    /// Commands that reached the driver.
    pub(crate) commands: AtomicUsize,
    /// Safing commands that reached the driver.
    pub(crate) safed: AtomicUsize,
    /// So many safing commands have no effect.
    pub(crate) deaf_to_safing: AtomicUsize,
    pub(crate) faults_in_safing: AtomicBool,
    pub(crate) panics_in_safing: AtomicBool,
    /// Safing does not come back until this is false, either.
    pub(crate) hangs_in_safing: AtomicBool,
    /// The next command does not come back until this is false.
    pub(crate) hold: AtomicBool,
    /// A command is being held.
    pub(crate) held: AtomicBool,
}

impl Truth {
    /// Waits until a command is inside the driver.
    pub(crate) fn wait_until_held(&self) {
        while !self.held.load(SeqCst) {
            std::thread::yield_now();
        }
    }
}

#[derive(Debug)]
pub(crate) struct Lamp {
    truth: &'static Truth,
    profile: Profile,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    /// On, with 5 W.
    On,
    Off,
    /// Nothing that draws.
    Blink,
    /// On, with 5 W and 10 mg/s.
    Burn,
    /// On, without draw.
    Glow,
    /// The driver faults.
    Fault,
    /// The driver panics.
    Panic,
}

impl Lamp {
    pub(crate) fn new(truth: &'static Truth, profile: Profile) -> Self {
        Self { truth, profile }
    }

    fn wait_while_held(&self) {
        self.truth.held.store(self.truth.hold.load(SeqCst), SeqCst);
        while self.truth.hold.load(SeqCst) {
            std::thread::yield_now();
        }
        self.truth.held.store(false, SeqCst);
    }
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = &'static str;

    fn profile(&self) -> Profile {
        self.profile
    }

    fn declare(command: &Switch) -> Declaration {
        let draw = Milliwatts::from_watts(5);
        let effect = match command {
            Switch::On => Effect::on(draw),
            Switch::Burn => Effect::On { draw, flow: MilligramsPerSecond::new(10) },
            Switch::Glow => Effect::on(Milliwatts::ZERO),
            Switch::Off => Effect::Off,
            Switch::Blink | Switch::Fault | Switch::Panic => Effect::Unchanged,
        };
        Declaration { code: *command as u16, wcet: Duration::from_millis(1), effect }
    }

    fn issue(&mut self, command: Switch) -> Result<(), &'static str> {
        self.truth.commands.fetch_add(1, SeqCst);
        self.wait_while_held();
        match command {
            Switch::Fault => return Err("blown"),
            Switch::Panic => panic!("the driver panicked, as the test wants"),
            Switch::On | Switch::Burn | Switch::Glow => self.truth.on.store(true, SeqCst),
            Switch::Off => self.truth.on.store(false, SeqCst),
            Switch::Blink => {}
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), &'static str> {
        self.truth.safed.fetch_add(1, SeqCst);
        if self.truth.panics_in_safing.load(SeqCst) {
            panic!("the driver panicked in safing, as the test wants");
        }
        if self.truth.faults_in_safing.load(SeqCst) {
            return Err("no contact");
        }
        if self.truth.hangs_in_safing.load(SeqCst) {
            self.wait_while_held();
        }
        let deaf = &self.truth.deaf_to_safing;
        if deaf.load(SeqCst) > 0 {
            deaf.fetch_sub(1, SeqCst);
        } else {
            self.truth.on.store(false, SeqCst);
        }
        Ok(())
    }
}
