//! Two gates of one agent behind a whole broker, revoked in every way that the
//! broker offers: with books, policies, hand-over and restoration.

use faregate::agents::{self, Revoked};
use faregate::prelude::*;
use faregate::runtime;
use faregate::runtime::clock::MonotonicClock;
use faregate::tickets::Gate;
use faregate::tickets::lock::Strategy;
use faregate::tickets::notify::{NoNotify, Notify};
use faregate::tickets::platform::Platform;
use faregate::tickets::recorder::NoLane;
use faregate_devices_sim::Dice;

use crate::gates::{Ports, Worker};
use crate::room::{Order, Room};
use crate::subject::{Outcome, Pass, Refused, Subject};

/// How many gates are soaked. The revoker has one more, for itself.
const GATES: usize = 2;

/// How an agent or a supervisor revokes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Request,
    Bar,
    AgentSafeMode,
    BrokerSafeMode,
    AllButMe,
}

const WAYS: [Way; 5] =
    [Way::Request, Way::Bar, Way::AgentSafeMode, Way::BrokerSafeMode, Way::AllButMe];

/// The broker that is soaked; beside this thread, others may serve it.
type Served<P, N, const G: usize, const T: usize, const S: usize> =
    &'static agents::Broker<'static, P, N, G, T, S>;

type Paper<Q, P, N, const G: usize, const T: usize, const S: usize> =
    faregate::tickets::Ticket<'static, Worker, Q, agents::Broker<'static, P, N, G, T, S>>;

/// A broker with two gates of platform `Q`, and who revokes their tickets.
pub(crate) struct Agents<Q, P, N, const G: usize, const T: usize, const S: usize>
where
    Q: Platform + 'static,
    P: Platform + 'static,
    N: Notify + 'static,
{
    broker: Served<P, N, G, T, S>,
    supervisors: Supervisors,
    rooms: [&'static Room; GATES],
    gates: [agents::Handle<'static, Worker, Q>; GATES],
    tickets: [TicketId; GATES],
    passes: Vec<AgentPass<Q, P, N, G, T, S>>,
    /// The revoker's own, for all but me.
    own: Paper<Q, P, N, G, T, S>,
    way: Way,
    target: usize,
    /// What is to be quiescent.
    revoked: Option<Revoked<'static>>,
    emergency: Option<Paper<Q, P, N, G, T, S>>,
}

#[derive(Debug)]
struct Supervisors {
    agent: Supervisor,
    broker: Supervisor,
}

/// A broker that the revoker serves itself, with gates behind the strategy `L`.
pub(crate) type ByHand<L> = Agents<Ports<L>, Ports<L>, NoNotify, 4, 8, 2>;

/// A broker with its service thread, recorder and wake-ups.
pub(crate) type WithService = Agents<
    runtime::host::Host,
    runtime::host::Host,
    &'static runtime::Waiters,
    { runtime::broker::GATES },
    { runtime::broker::TICKETS },
    { runtime::broker::SETS },
>;

impl<L: Strategy> ByHand<L> {
    pub(crate) fn new() -> Outcome<Self> {
        let clock = MonotonicClock::new();
        let mut broker =
            Box::new(agents::Broker::<Ports<L>, _, 4, 8, 2>::new(clock, NoLane, NoNotify));
        let rooms = [(); GATES].map(|()| Room::leaked());
        let soaked = broker.agent(Policy::unlimited())?;
        let other = broker.agent(Policy::unlimited())?;
        let mut gate = |agent, room| {
            let gate = Gate::<_, Ports<L>>::new(Worker(room), clock, NoLane);
            broker.register(agent, Box::leak(Box::new(gate)).key())
        };
        let gates = [gate(soaked, rooms[0])?, gate(soaked, rooms[1])?];
        let own = gate(other, Room::leaked())?;
        let supervisors =
            Supervisors { agent: broker.supervisor_of(soaked)?, broker: broker.supervisor() };
        Self::with(Box::leak(broker), supervisors, rooms, gates, own)
    }
}

impl WithService {
    pub(crate) fn new() -> Outcome<Self> {
        let mut builder = runtime::Broker::builder()?;
        let rooms = [(); GATES].map(|()| Room::leaked());
        let soaked = builder.agent(Policy::unlimited())?;
        let other = builder.agent(Policy::unlimited())?;
        let gates = [
            builder.gate(soaked, "one", Worker(rooms[0]))?,
            builder.gate(soaked, "two", Worker(rooms[1]))?,
        ];
        let own = builder.gate(other, "own", Worker(Room::leaked()))?;
        let supervisors =
            Supervisors { agent: builder.supervisor_of(soaked)?, broker: builder.supervisor() };
        Self::with(builder.start()?.agents(), supervisors, rooms, gates, own)
    }
}

impl<Q: Platform, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Agents<Q, P, N, G, T, S>
{
    fn with(
        broker: Served<P, N, G, T, S>,
        supervisors: Supervisors,
        rooms: [&'static Room; GATES],
        gates: [agents::Handle<'static, Worker, Q>; GATES],
        own: agents::Handle<'static, Worker, Q>,
    ) -> Outcome<Self> {
        let mut passes = Vec::new();
        for ((holder, gate), room) in (1..).zip(&gates).zip(&rooms) {
            room.open_for(holder);
            passes.push(AgentPass { holder, ticket: broker.request(Priority::SCIENCE, gate)? });
        }
        let tickets = [passes[0].ticket.id(), passes[1].ticket.id()];
        let own = broker.request(Priority::ENGINEERING, &own)?;
        broker.service();
        let (way, target, revoked, emergency) = (Way::Bar, 0, None, None);
        Ok(Self {
            broker,
            supervisors,
            rooms,
            gates,
            tickets,
            passes,
            own,
            way,
            target,
            revoked,
            emergency,
        })
    }

    /// Serves until the ticket is valid. Where there is a service thread, it may
    /// be in the midst of a step that it has to end.
    fn serve(&self, ticket: &Paper<Q, P, N, G, T, S>) -> Outcome<()> {
        for _ in 0..100_000 {
            self.broker.service();
            if ticket.check().is_ok() {
                return Ok(());
            }
            std::thread::yield_now();
        }
        let waits = self.broker.waiting_for(ticket.id());
        Err(format!("{:?}: {} is not valid; it waits for {waits:?}", self.way, ticket.id()).into())
    }
}

impl<Q: Platform, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize> Subject
    for Agents<Q, P, N, G, T, S>
{
    type Pass = AgentPass<Q, P, N, G, T, S>;

    fn rooms(&self) -> &[&'static Room] {
        &self.rooms
    }

    fn hand_out(&mut self) -> Vec<Self::Pass> {
        std::mem::take(&mut self.passes)
    }

    fn aim(&mut self, dice: &mut Dice) -> Outcome<u32> {
        self.way = WAYS[dice.index(WAYS.len())];
        self.target = dice.index(GATES);
        Ok(match self.way {
            Way::Request | Way::Bar => 1 << self.target,
            Way::AgentSafeMode | Way::BrokerSafeMode | Way::AllButMe => (1 << GATES) - 1,
        })
    }

    fn revoke(&mut self) -> Outcome<()> {
        let (broker, floor) = (self.broker, Priority::EMERGENCY);
        let revoked = match self.way {
            Way::Request => {
                self.emergency = Some(broker.request(floor, &self.gates[self.target])?);
                return Ok(());
            }
            Way::Bar => broker.bar(&self.supervisors.broker, self.tickets[self.target])?,
            Way::AgentSafeMode => broker.enter_safe_mode(&self.supervisors.agent, floor)?,
            Way::BrokerSafeMode => broker.enter_safe_mode(&self.supervisors.broker, floor)?,
            Way::AllButMe => {
                let all = broker.revoke_all_but_me(&self.supervisors.broker, &self.own, floor)?;
                if !all.0 {
                    return Err("all but me: the revoker's own ticket was revoked too".into());
                }
                all.1
            }
        };
        self.revoked = Some(revoked);
        Ok(())
    }

    fn quiesce(&mut self) -> Outcome<()> {
        if let Some(emergency) = &self.emergency {
            return self.serve(emergency);
        }
        if let Some(revoked) = self.revoked.take() {
            revoked.quiesce()?;
        }
        Ok(())
    }

    fn next(&mut self, room: usize, _: &mut Dice) -> u8 {
        u8::try_from(room + 1).unwrap_or(u8::MAX)
    }

    fn admit(&mut self) -> Outcome<()> {
        // Where quiescence was skipped on purpose, it is over by now.
        self.revoked = None;
        self.emergency = None;
        match self.way {
            Way::Request => {}
            Way::Bar => {
                self.broker.reinstate(&self.supervisors.broker, self.tickets[self.target])?;
            }
            Way::AgentSafeMode => self.broker.leave_safe_mode(&self.supervisors.agent)?,
            Way::BrokerSafeMode | Way::AllButMe => {
                self.broker.leave_safe_mode(&self.supervisors.broker)?;
            }
        }
        self.serve(&self.own)
    }
}

/// A holder's ticket.
pub(crate) struct AgentPass<Q, P, N, const G: usize, const T: usize, const S: usize>
where
    Q: Platform + 'static,
    P: Platform + 'static,
    N: Notify + 'static,
{
    holder: u8,
    ticket: Paper<Q, P, N, G, T, S>,
}

impl<Q: Platform, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize> Pass
    for AgentPass<Q, P, N, G, T, S>
{
    fn holder(&self) -> u8 {
        self.holder
    }

    fn invoke(&self, order: Order) -> Result<(), Refused> {
        self.ticket.invoke(order).map_err(|error| Refused { why: error.refusal() })
    }
}
