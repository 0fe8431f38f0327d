//! Simulated lamps, whose truth the test sees.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use faregate_agents::Categories;
use faregate_scheduler::mission::DeviceSpec;
use faregate_scheduler::time::Duration;
use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::device::{Declaration, Effect, Profile};

pub(crate) const LAMP: Milliwatts = Milliwatts::from_watts(8);

#[derive(Debug, Default)]
pub(crate) struct Truth {
    pub(crate) on: AtomicBool,
    /// Whether a command waits until this is false.
    pub(crate) slow: AtomicBool,
    pub(crate) inside: AtomicBool,
}

pub(crate) struct Lamp(pub(crate) Arc<Truth>);

#[derive(Clone, Copy)]
pub(crate) enum Switch {
    On,
    Off,
    Break,
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = &'static str;

    fn profile(&self) -> Profile {
        let mut profile = Profile::new().drawing(LAMP);
        profile.longest_command = Duration::from_secs(20);
        profile.longest_safing = Duration::from_secs(20);
        profile.estimate_lag = Duration::from_secs(5);
        profile
    }
    fn declare(command: &Switch) -> Declaration {
        let effect = match command {
            Switch::On => Effect::on(LAMP),
            Switch::Off => Effect::Off,
            Switch::Break => Effect::Unchanged,
        };
        Declaration { code: *command as u16, wcet: Duration::from_secs(20), effect }
    }
    fn issue(&mut self, command: Switch) -> Result<(), &'static str> {
        self.0.inside.store(true, SeqCst);
        while self.0.slow.load(SeqCst) {
            std::thread::yield_now();
        }
        self.0.inside.store(false, SeqCst);
        match command {
            Switch::Break => return Err("its filament broke"),
            _ => self.0.on.store(matches!(command, Switch::On), SeqCst),
        }
        Ok(())
    }
    fn safe(&mut self) -> Result<(), &'static str> {
        self.0.on.store(false, SeqCst);
        Ok(())
    }
}

pub(crate) fn spec(name: &str) -> DeviceSpec {
    DeviceSpec {
        name: name.into(),
        kind: "lamp".into(),
        agent: "power".into(),
        draw: None,
        categories: Categories::NONE,
        parameters: BTreeMap::new(),
    }
}
