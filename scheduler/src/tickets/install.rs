//! A mission's agents, gates and places, put together once.

use core::fmt;
use std::io;
use std::sync::Arc;

use faregate_agents::{AgentId, Policy, RegisterError, Supervisor};
use faregate_runtime::broker::GATES;
use faregate_runtime::{Broker, Builder, GateOptions};

use super::SLOTS;
use super::authority::Shared;
use super::driver::{Driver, GateDevice};
use super::gates::{Gates, NamedGate};
use super::place::{Place, PlaceBook};
use super::port::Tickets;
use crate::executive::Waker;
use crate::mission::{DeviceSpec, Mission};
use crate::time::Duration;

/// A mission's broker while it is put together: agents first, then devices.
#[derive(Debug)]
pub struct Installation {
    builder: Builder,
    agents: Vec<(String, AgentId)>,
    gates: Gates,
    places: Vec<PlaceBook>,
    waker: Waker,
    lease: Duration,
}

/// Why a mission could not be installed.
#[derive(Debug)]
#[non_exhaustive]
pub enum NotInstalled {
    /// The host lacks what a broker needs.
    Host(io::Error),
    /// The mission names no agent.
    NoAgent,
    /// There is no such agent.
    UnknownAgent {
        /// The device.
        device: String,
        /// The name of the agent.
        agent: String,
    },
    /// Two devices have this name.
    NameTwice(String),
    /// More agents or devices than a broker has room for.
    TooMany(&'static str),
}

impl fmt::Display for NotInstalled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Host(error) => write!(f, "the host has no room for a broker: {error}"),
            Self::NoAgent => f.write_str("the mission names no agent; it takes at least one"),
            Self::UnknownAgent { device, agent } => {
                write!(f, "device `{device}` belongs to agent `{agent}`, which is not there")
            }
            Self::NameTwice(name) => write!(f, "two devices have the name `{name}`"),
            Self::TooMany("devices") => {
                write!(f, "too many devices: there is room for {}", GATES - SLOTS)
            }
            Self::TooMany(what) => write!(f, "too many {what} for one broker"),
        }
    }
}

impl std::error::Error for NotInstalled {}

impl From<io::Error> for NotInstalled {
    fn from(error: io::Error) -> Self {
        Self::Host(error)
    }
}

impl Installation {
    /// The agents of this mission, and places for its tasks at the first of
    /// them. The port will ring this bell.
    ///
    /// # Errors
    /// [`NotInstalled`].
    pub fn new(mission: &Mission, waker: &Waker) -> Result<Self, NotInstalled> {
        let mut builder = Broker::builder()?;
        let mut agents = Vec::new();
        for spec in &mission.agents {
            let policy = Policy::categories();
            let policy = match spec.supply {
                Some(supply) => policy.with_power_margin(supply),
                None => policy,
            };
            let full = |_: RegisterError| NotInstalled::TooMany("agents");
            agents.push((spec.name.clone(), builder.agent(policy).map_err(full)?));
        }
        let (_, first) = *agents.first().ok_or(NotInstalled::NoAgent)?;
        let mut places = Vec::new();
        for number in 1..=SLOTS {
            let place = Place::new(waker.clone());
            let handle = builder.gate(first, &format!("place {number}"), place);
            places.push(PlaceBook::new(handle.map_err(|_| NotInstalled::TooMany("places"))?));
        }
        let (gates, waker, lease) = (Gates::default(), waker.clone(), mission.lease);
        Ok(Self { builder, agents, gates, places, waker, lease })
    }

    /// Moves a driver behind a gate, which tasks call by the device's name.
    ///
    /// # Errors
    /// [`NotInstalled`].
    pub fn device(
        &mut self,
        spec: &DeviceSpec,
        driver: Box<dyn Driver>,
    ) -> Result<(), NotInstalled> {
        if self.gates.get(&spec.name).is_some() {
            return Err(NotInstalled::NameTwice(spec.name.clone()));
        }
        let agent = self.agents.iter().find(|(name, _)| *name == spec.agent);
        let unknown =
            || NotInstalled::UnknownAgent { device: spec.name.clone(), agent: spec.agent.clone() };
        let (_, agent) = *agent.ok_or_else(unknown)?;
        let catalogue = driver.catalogue();
        let device = GateDevice::new(driver, spec.draw.unwrap_or_default());
        let profile = faregate_tickets::Device::profile(&device);
        let options = GateOptions::new().categories(spec.categories);
        let handle = self.builder.gate_with(agent, &spec.name, device, options);
        let handle = handle.map_err(|_| NotInstalled::TooMany("devices"))?;
        self.gates.add(NamedGate::new(&spec.name, handle, catalogue, profile));
        Ok(())
    }

    /// Whether a driver was given for the device of this name.
    #[must_use]
    pub fn has(&self, device: &str) -> bool {
        self.gates.get(device).is_some()
    }

    /// Makes a supervisor of the whole broker: it can bar tasks, enter safe
    /// mode, and reset faulted gates.
    pub fn supervisor(&mut self) -> Supervisor {
        self.builder.supervisor()
    }

    /// The agent of this name, for supplies and reports.
    #[must_use]
    pub fn agent(&self, name: &str) -> Option<AgentId> {
        self.agents.iter().find(|(known, _)| known == name).map(|(_, agent)| *agent)
    }

    /// Runs the broker's service with SCHED_FIFO at this priority; see
    /// [`Builder::real_time`].
    #[must_use]
    pub fn real_time(mut self, priority: u8) -> Self {
        self.builder = self.builder.real_time(priority);
        self
    }

    /// Starts the broker.
    ///
    /// # Errors
    /// When the host has no thread or file descriptor left.
    pub fn start(self) -> Result<Tickets, NotInstalled> {
        let Self { builder, gates, places, waker, lease, .. } = self;
        // What has become of a ticket, the ticket says.
        let broker = builder.watch(move |_, _| waker.wake()).start()?;
        Ok(Tickets::new(broker, Arc::new(Shared::new(gates)), places, lease))
    }
}
