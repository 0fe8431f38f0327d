//! One lamp behind a broker that its user serves, with the host's ports.

use std::error::Error;
use std::sync::atomic::{AtomicU32, Ordering};

use faregate_agents::{Broker, Handle, Policy, Supervisor};
use faregate_runtime::clock::MonotonicClock;
use faregate_runtime::host::{Host, Supported};
use faregate_runtime::lanes::Recorder;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Effect, Profile};
use faregate_tickets::notify::NoNotify;
use faregate_tickets::{Device, Gate};

pub(crate) type Outcome<T> = Result<T, Box<dyn Error>>;

pub(crate) type Books<S> = Broker<'static, Host<S>, NoNotify, 2, 4, 0>;
pub(crate) type Ticket<S> = faregate_tickets::Ticket<'static, Lamp, Host<S>, Books<S>>;

pub(crate) struct Bench<S: Supported> {
    pub(crate) broker: &'static Books<S>,
    pub(crate) lamp: Handle<'static, Lamp, Host<S>>,
    /// On another lamp, for all but me.
    pub(crate) own: Ticket<S>,
    pub(crate) supervisor: Supervisor,
    pub(crate) of_agent: Supervisor,
    _recorder: Recorder,
}

impl<S: Supported> Bench<S> {
    pub(crate) fn new() -> Outcome<Self> {
        let (clock, mut recorder) = (MonotonicClock::new(), Recorder::new());
        let mut broker = Box::new(Books::<S>::new(clock, recorder.lane("broker", 64), NoNotify));
        let (agent, other) =
            (broker.agent(Policy::unlimited())?, broker.agent(Policy::unlimited())?);
        let mut gate = |agent| {
            let gate = Gate::<_, Host<S>>::new(Lamp, clock, recorder.lane("lamp", 64));
            broker.register(agent, Box::leak(Box::new(gate)).key())
        };
        let (lamp, own) = (gate(agent)?, gate(other)?);
        let (supervisor, of_agent) = (broker.supervisor(), broker.supervisor_of(agent)?);
        let broker: &'static Books<S> = Box::leak(broker);
        let own = broker.request(faregate_tickets::id::Priority::ENGINEERING, &own)?;
        broker.service();
        Ok(Self { broker, lamp, own, supervisor, of_agent, _recorder: recorder })
    }
}

static LEVEL: AtomicU32 = AtomicU32::new(0);

/// A lamp without draw.
pub(crate) struct Lamp;

#[derive(Clone, Copy, Debug)]
pub(crate) enum Switch {
    On,
    Off,
    /// One store.
    Dim(u32),
    /// The driver sleeps for so long.
    Sleep(std::time::Duration),
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = &'static str;

    fn profile(&self) -> Profile {
        let mut profile = Profile::new();
        profile.longest_command = Duration::from_secs(5);
        profile
    }

    fn declare(_: &Switch) -> Declaration {
        Declaration { code: 1, wcet: Duration::from_secs(5), effect: Effect::Unchanged }
    }

    fn issue(&mut self, command: Switch) -> Result<(), &'static str> {
        match command {
            Switch::On | Switch::Off => {}
            Switch::Dim(level) => LEVEL.store(level, Ordering::Relaxed),
            Switch::Sleep(time) => std::thread::sleep(time),
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), &'static str> {
        Ok(())
    }

    fn register(&self) -> Option<&'static AtomicU32> {
        Some(&LEVEL)
    }

    fn word(command: &Switch) -> Option<(u32, ())> {
        match command {
            Switch::Dim(level) => Some((*level, ())),
            _ => None,
        }
    }
}
