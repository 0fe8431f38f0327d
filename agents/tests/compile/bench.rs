//! What every case starts from: a lamp, its gate, and a broker with one agent.

use std::convert::Infallible;

use faregate_agents::{AgentId, Broker, Policy};
use faregate_tickets::clock::{Clock, Duration, Instant};
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::lock::Locked;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;

pub type Platform = (Locked<parking_lot::RawMutex, parking_lot::RawThreadId>, Stopped, NoLane);
pub type Gate = faregate_tickets::Gate<'static, Lamp, Platform>;
pub type LampBroker<'g> = Broker<'g, Platform, NoNotify, 2, 4, 1>;

/// A clock that stands still: no case takes time.
#[derive(Debug)]
pub struct Stopped;

impl Clock for Stopped {
    fn now(&self) -> Instant {
        Instant::START
    }
}

/// A lamp that draws nothing, so that it needs neither lease nor sensors. It
/// answers each command with whether it is lit.
#[derive(Debug, Default)]
pub struct Lamp {
    lit: bool,
}

#[derive(Clone, Copy, Debug)]
pub enum Switch {
    On,
    Off,
    /// Changes nothing.
    Look,
}

impl Device for Lamp {
    type Command = Switch;
    type Response = bool;
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        Profile::new()
    }

    fn declare(command: &Switch) -> Declaration {
        let wcet = Duration::from_millis(1);
        Declaration { code: *command as u16, wcet, effect: Effect::Unchanged }
    }

    fn issue(&mut self, command: Switch) -> Result<bool, Infallible> {
        self.lit = match command {
            Switch::On => true,
            Switch::Off => false,
            Switch::Look => self.lit,
        };
        Ok(self.lit)
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        self.lit = false;
        Ok(())
    }
}

/// A gate around a lamp of its own.
pub fn gate() -> Gate {
    Gate::new(Lamp::default(), Stopped, NoLane)
}

/// A broker whose one agent limits nothing beyond one tenant for each gate.
pub fn broker<'g>() -> (LampBroker<'g>, AgentId) {
    let mut broker = LampBroker::new(Stopped, NoLane, NoNotify);
    let agent = broker.agent(Policy::unlimited()).unwrap();
    (broker, agent)
}
