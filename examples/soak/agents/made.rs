//! How the brokers are put together.

use faregate::agents;
use faregate::prelude::*;
use faregate::runtime;
use faregate::runtime::clock::MonotonicClock;
use faregate::runtime::host::Supported;
use faregate::tickets::Gate;
use faregate::tickets::notify::NoNotify;
use faregate::tickets::recorder::NoLane;

use super::{ByHand, GATES, Supervisors, Threads, WithService};
use crate::driver::Driver;
use crate::gates::Ports;
use crate::room::Room;
use crate::strategies::Soaked;
use crate::subject::Outcome;

/// The scheduler's priority of the service thread: below the revoker, which
/// serves too, above the holders.
const SERVICE: u8 = 15;

impl<D: Driver + 'static, L: Soaked, B: Soaked> ByHand<D, L, B> {
    pub(crate) fn by_hand() -> Outcome<Self> {
        L::check()?;
        B::check()?;
        let clock = MonotonicClock::new();
        let mut broker =
            Box::new(agents::Broker::<Ports<B>, _, 4, 8, 2>::new(clock, NoLane, NoNotify));
        let rooms = [(); GATES].map(|()| Room::leaked());
        let soaked = broker.agent(Policy::unlimited())?;
        let other = broker.agent(Policy::unlimited())?;
        let mut gate = |agent, room| {
            let gate = Gate::<_, Ports<L>>::new(D::new(room), clock, NoLane);
            broker.register(agent, Box::leak(Box::new(gate)).key())
        };
        let gates = [gate(soaked, rooms[0])?, gate(soaked, rooms[1])?];
        let own = gate(other, Room::leaked())?;
        let supervisors =
            Supervisors { agent: broker.supervisor_of(soaked)?, broker: broker.supervisor() };
        Self::with(Box::leak(broker), Threads(None), supervisors, rooms, gates, own)
    }
}

impl<D: Driver + 'static, L: Supported> WithService<D, L> {
    pub(crate) fn with_service() -> Outcome<Self> {
        let mut builder = runtime::Broker::builder()?;
        let rooms = [(); GATES].map(|()| Room::leaked());
        let soaked = builder.agent(Policy::unlimited())?;
        let other = builder.agent(Policy::unlimited())?;
        let mut gate = |agent, name, room| {
            builder.gate_behind::<L, _>(agent, name, D::new(room), GateOptions::new())
        };
        let gates = [gate(soaked, "one", rooms[0])?, gate(soaked, "two", rooms[1])?];
        let own = gate(other, "own", Room::leaked())?;
        let supervisors =
            Supervisors { agent: builder.supervisor_of(soaked)?, broker: builder.supervisor() };
        let broker = builder.real_time(SERVICE).start()?;
        Self::with(broker.agents(), Threads(Some(broker)), supervisors, rooms, gates, own)
    }
}
