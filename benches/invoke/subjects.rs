//! Tickets of a real broker, whose gates stand on the ports of the row.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use faregate::agents::{Broker, Handle, Policy, Supervisor};
use faregate::prelude::*;
use faregate::runtime::clock::MonotonicClock;
use faregate::tickets::lock::Strategy;
use faregate::tickets::notify::NoNotify;
use faregate::tickets::recorder::NoLane;
use faregate::tickets::{Gate, Platform};

use crate::register::{Driver, Register};
use crate::support::Failure;

/// A clock of one load, which stands still: what the gate itself costs.
#[derive(Debug, Default)]
pub(crate) struct Hands(AtomicU64);

impl Clock for Hands {
    fn now(&self) -> Instant {
        Instant::from_micros(self.0.load(Relaxed))
    }
}

/// The ports of the rows with a target: nothing but the strategy counts.
pub(crate) type Free<S> = (S, Hands, NoLane);

/// With the host's clock, and no recorder.
pub(crate) type Clocked<S> = (S, MonotonicClock, NoLane);

type Books<P> = Broker<'static, P, NoNotify, 1, 4, 0>;

/// A ticket of [`Stand`].
pub(crate) type Pass<P, const SITE: u8> =
    faregate::tickets::Ticket<'static, Driver<SITE>, P, Books<P>>;

/// A broker with one register behind a gate.
pub(crate) struct Stand<P: Platform + 'static, const SITE: u8> {
    pub(crate) broker: &'static Books<P>,
    pub(crate) supervisor: Supervisor,
    pub(crate) handle: Handle<'static, Driver<SITE>, P>,
}

impl<S: Strategy, const SITE: u8> Stand<Free<S>, SITE> {
    pub(crate) fn free() -> Result<Self, Failure> {
        Self::new(Hands::default(), Hands::default(), NoLane, NoLane)
    }
}

impl<P: Platform, const SITE: u8> Stand<P, SITE> {
    /// The clocks and lanes of the broker and of the gate.
    pub(crate) fn new(
        brokers: P::Clock,
        gates: P::Clock,
        lane: P::Lane,
        gates_lane: P::Lane,
    ) -> Result<Self, Failure> {
        let gate = Gate::new(Driver(Register::installed()), gates, gates_lane);
        let gate: &'static mut Gate<'static, Driver<SITE>, P> = Box::leak(Box::new(gate));
        let broker = Box::leak(Box::new(Books::<P>::new(brokers, lane, NoNotify)));
        let supervisor = broker.supervisor();
        let agent = broker.agent(Policy::exclusive())?;
        let handle = broker.register(agent, gate.key())?;
        Ok(Self { broker, supervisor, handle })
    }

    /// A valid ticket.
    pub(crate) fn ticket(&self, validity: impl Into<Validity>) -> Result<Pass<P, SITE>, Failure> {
        let ticket = self.broker.request(Priority::SCIENCE, &self.handle.limited(validity))?;
        self.broker.service();
        ticket.check()?;
        Ok(ticket)
    }
}
