//! Simulated lamps, which count what they are told.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::mission::DeviceSpec;
use faregate_scheduler::time::Duration;
use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::device::{Declaration, Effect, Profile};

pub(crate) const LAMP: Milliwatts = Milliwatts::from_watts(8);

#[derive(Debug, Default)]
pub(crate) struct Truth {
    pub(crate) on: AtomicBool,
    pub(crate) commands: AtomicUsize,
}

pub(crate) struct Lamp(pub(crate) Arc<Truth>);

impl Device for Lamp {
    type Command = bool;
    type Response = ();
    type Fault = &'static str;

    fn profile(&self) -> Profile {
        let mut profile = Profile::new().drawing(LAMP);
        profile.longest_command = Duration::from_secs(20);
        profile.longest_safing = Duration::from_secs(20);
        profile.estimate_lag = Duration::from_secs(5);
        profile
    }
    fn declare(on: &bool) -> Declaration {
        let effect = if *on { Effect::on(LAMP) } else { Effect::Off };
        Declaration { code: (*on).into(), wcet: Duration::from_secs(20), effect }
    }
    fn issue(&mut self, on: bool) -> Result<(), &'static str> {
        self.0.on.store(on, SeqCst);
        self.0.commands.fetch_add(1, SeqCst);
        Ok(())
    }
    fn safe(&mut self) -> Result<(), &'static str> {
        self.0.on.store(false, SeqCst);
        Ok(())
    }
}

pub(crate) const LAMPS: [&str; 2] = ["floodlight", "beacon"];

/// Two lamps, two engines, 42 W.
pub(crate) fn mission() -> Mission {
    // A host that is slow does not lose its tickets for it.
    let mut mission = Mission { lease: Duration::from_secs(60), ..Mission::default() };
    mission.agents[0].supply = Some(Milliwatts::from_watts(42));
    mission.categories = [("engine 1".to_owned(), 64), ("engine 2".to_owned(), 65)].into();
    mission.devices = LAMPS.map(device).to_vec();
    mission
}

fn device(name: &str) -> DeviceSpec {
    DeviceSpec {
        name: name.into(),
        kind: "lamp".into(),
        agent: "tasks".into(),
        draw: Some(LAMP),
        categories: Categories::NONE,
        parameters: Default::default(),
    }
}
