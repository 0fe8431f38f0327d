//! Two gates of one agent behind a whole broker, revoked in every way that the
//! broker offers: with books, policies, hand-over and restoration.

mod made;

use faregate::agents::{self, Revoked};
use faregate::prelude::*;
use faregate::runtime;
use faregate::runtime::host::Host;
use faregate::tickets::notify::{NoNotify, Notify};
use faregate::tickets::platform::Platform;
use faregate_devices_sim::Dice;

use crate::driver::Driver;
use crate::gates::Ports;
use crate::room::{Order, Room};
use crate::subject::{Orders, Outcome, Pass, Subject};

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

type Paper<D, Q, P, N, const G: usize, const T: usize, const S: usize> =
    faregate::tickets::Ticket<'static, D, Q, agents::Broker<'static, P, N, G, T, S>>;

/// A broker with two gates of platform `Q`, and who revokes their tickets.
pub(crate) struct Agents<D, Q, P, N, const G: usize, const T: usize, const S: usize>
where
    D: Driver + 'static,
    Q: Platform + 'static,
    P: Platform + 'static,
    N: Notify + 'static,
{
    broker: Served<P, N, G, T, S>,
    supervisors: Supervisors,
    rooms: [&'static Room; GATES],
    gates: [agents::Handle<'static, D, Q>; GATES],
    tickets: [TicketId; GATES],
    passes: Vec<AgentPass<D, Q, P, N, G, T, S>>,
    /// The revoker's own, for all but me.
    own: Paper<D, Q, P, N, G, T, S>,
    way: Way,
    target: usize,
    /// What is to be quiescent.
    revoked: Option<Revoked<'static>>,
    emergency: Option<Paper<D, Q, P, N, G, T, S>>,
    /// After all tickets.
    _threads: Threads,
}

/// The threads of a broker that has some: they end with it.
#[derive(Debug)]
struct Threads(Option<runtime::Broker>);

impl Drop for Threads {
    fn drop(&mut self) {
        if let Some(broker) = self.0.take() {
            // Should a ticket be held after all, its threads go on with it.
            let _ = broker.close();
        }
    }
}

#[derive(Debug)]
struct Supervisors {
    agent: Supervisor,
    broker: Supervisor,
}

/// A broker that the revoker serves itself. Its gates are behind the strategy
/// `L`, its books behind `B`.
pub(crate) type ByHand<D, L, B> = Agents<D, Ports<L>, Ports<B>, NoNotify, 4, 8, 2>;

/// A broker with its service thread, recorder and wake-ups. Its gates are
/// behind the strategy `L`.
pub(crate) type WithService<D, L> = Agents<
    D,
    Host<L>,
    Host,
    &'static runtime::Waiters,
    { runtime::broker::GATES },
    { runtime::broker::TICKETS },
    { runtime::broker::SETS },
>;

impl<D: Driver, Q: Platform, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Agents<D, Q, P, N, G, T, S>
{
    fn with(
        broker: Served<P, N, G, T, S>,
        threads: Threads,
        supervisors: Supervisors,
        rooms: [&'static Room; GATES],
        gates: [agents::Handle<'static, D, Q>; GATES],
        own: agents::Handle<'static, D, Q>,
    ) -> Outcome<Self> {
        let mut passes = Vec::new();
        for ((holder, gate), room) in (1..).zip(&gates).zip(&rooms) {
            room.open_for(holder);
            let ticket = broker.request(Priority::SCIENCE, gate)?;
            passes.push(AgentPass { holder, room, ticket });
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
            _threads: threads,
        })
    }

    /// Serves until the ticket is valid. Where there is a service thread, it may
    /// be in the midst of a step that it has to end.
    fn serve(&self, ticket: &Paper<D, Q, P, N, G, T, S>) -> Outcome<()> {
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

impl<D: Driver, Q: Platform, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Subject for Agents<D, Q, P, N, G, T, S>
{
    type Pass = AgentPass<D, Q, P, N, G, T, S>;

    fn orders(&self) -> Orders {
        D::ORDERS
    }

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
pub(crate) struct AgentPass<D, Q, P, N, const G: usize, const T: usize, const S: usize>
where
    D: Driver + 'static,
    Q: Platform + 'static,
    P: Platform + 'static,
    N: Notify + 'static,
{
    holder: u8,
    room: &'static Room,
    ticket: Paper<D, Q, P, N, G, T, S>,
}

impl<D: Driver, Q: Platform, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Pass for AgentPass<D, Q, P, N, G, T, S>
{
    fn holder(&self) -> u8 {
        self.holder
    }

    fn room(&self) -> &'static Room {
        self.room
    }

    fn invoke(&self, order: Order) -> Result<(), Option<Refusal>> {
        self.ticket.invoke(order).map_err(|error| error.refusal())
    }
}
