//! Rows of the whole hand-over: from the emergency's request until its first
//! command is issued, while the victim is pre-empted inside a command.

use std::sync::Arc;

use faregate::agents::{self, Policy};
use faregate::prelude::{Broker, Clock, Duration, GateOptions, Handle, Priority, Ticket};
use faregate::runtime::clock::MonotonicClock;
use faregate::runtime::host::Supported;
use faregate::tickets::gate::Gate;
use faregate::tickets::notify::NoNotify;
use faregate::tickets::recorder::NoLane;

use super::Outcome;
use super::device::{Driver, Order, Patience};
use super::gates::Behind;
use super::measured::Measured;
use super::rights::{self, SERVICE};
use super::stage::{Answer, Cue, Limits, Revoker, Stage};

type Ports<S> = (S, MonotonicClock, NoLane);
type Agents<'g, S> = agents::Broker<'g, Ports<S>, NoNotify, 1, 4, 0>;
/// How long an emergency waits at most.
const PATIENCE: Duration = Patience::Long.duration();

type Pass<'b, 'g, S> = faregate::tickets::Ticket<'b, Driver, Ports<S>, Agents<'g, S>>;

/// Without other threads: the requester does what is due itself.
pub(crate) fn by_requester<S: Behind>(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    let clock = MonotonicClock::new();
    let mut gate = Gate::<_, Ports<S>>::new(driver(stage), clock, NoLane);
    let mut broker: Box<Agents<'_, S>> = Box::new(agents::Broker::new(clock, NoLane, NoNotify));
    let agent = broker.agent(Policy::exclusive())?;
    let device = broker.register(agent, gate.key())?;
    let science = broker.request(Priority::SCIENCE, &device)?;
    let emergency = ByRequester { broker: &*broker, device, ticket: None };
    let command = move || {
        science.invoke(Order::Store(0))?;
        Ok(science.invoke(Order::BePreempted)?)
    };
    stage.play(Cue::Inside, limits, command, emergency)
}

struct ByRequester<'b, 'g, S: Behind> {
    broker: &'b Agents<'g, S>,
    device: agents::Handle<'g, Driver, Ports<S>>,
    ticket: Option<Pass<'b, 'g, S>>,
}

impl<S: Behind> Revoker for ByRequester<'_, '_, S> {
    fn prepare(&mut self) -> Outcome<()> {
        self.ticket = None;
        self.broker.service();
        Ok(())
    }

    fn measured(&mut self) -> Outcome<Answer> {
        let ticket = self.broker.request(Priority::EMERGENCY, &self.device)?;
        let deadline = MonotonicClock::new().now().after(PATIENCE);
        while ticket.check().is_err() {
            self.broker.service();
            if MonotonicClock::new().now() > deadline {
                return Ok(Answer::GaveUp);
            }
        }
        ticket.invoke(Order::Store(1))?;
        self.ticket = Some(ticket);
        Ok(Answer::Done)
    }
}

/// As programs have it: with a service thread above all holders.
pub(crate) fn with_service<S: Supported>(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    let mut builder = Broker::builder()?;
    let agent = builder.agent(Policy::exclusive())?;
    let device = builder.gate_behind::<S, _>(agent, "device", driver(stage), GateOptions::new())?;
    let cpu = stage.placement().revoker_cpu;
    let started = std::thread::spawn(move || {
        // The service thread inherits the CPU, and asks for its own priority.
        rights::take(cpu, rights::HOLDER)?;
        Ok::<_, super::Failure>(builder.real_time(SERVICE).start()?)
    });
    let broker = started.join().map_err(|_| "the broker did not start")??;
    let science = broker.request(Priority::SCIENCE, &device)?;
    broker.wait(&science, Duration::from_secs(1))?;
    let command = move || {
        science.invoke(Order::Store(0))?;
        Ok(science.invoke(Order::BePreempted)?)
    };
    let emergency = WithService { broker: &broker, device, ticket: None };
    let measured = stage.play(Cue::Inside, limits, command, emergency);
    broker.close()?;
    measured
}

struct WithService<'b, S: Supported> {
    broker: &'b Broker,
    device: Handle<Driver, S>,
    ticket: Option<Ticket<Driver, S>>,
}

impl<S: Supported> Revoker for WithService<'_, S> {
    fn prepare(&mut self) -> Outcome<()> {
        self.ticket = None;
        self.broker.agents().service();
        Ok(())
    }

    fn measured(&mut self) -> Outcome<Answer> {
        let ticket = self.broker.request(Priority::EMERGENCY, &self.device)?;
        self.broker.wait(&ticket, PATIENCE)?;
        ticket.invoke(Order::Store(1))?;
        self.ticket = Some(ticket);
        Ok(Answer::Done)
    }
}

fn driver(stage: &Arc<Stage>) -> Driver {
    Driver { stage: Arc::clone(stage), patience: Patience::Long }
}
