//! One gate with two tickets, revoked through its key: what a ticket agent does
//! beneath its books, and nothing else. Fast enough for millions.

use std::marker::PhantomData;

use faregate::prelude::*;
use faregate::runtime::clock::MonotonicClock;
use faregate::runtime::contain::Caught;
use faregate::tickets::gate::{Admission, Gate, Key};
use faregate::tickets::lock::Strategy;
use faregate::tickets::platform::Platform;
use faregate::tickets::recorder::{NoLane, Unrecorded};
use faregate::tickets::scope::Scope;
use faregate::tickets::standing::{Stamp, Standing};
use faregate::tickets::ticket::{Holder, Issuer, Seat};
use faregate_devices_sim::Dice;

use crate::driver::{Driver, PATIENCE};
use crate::room::{Order, Room};
use crate::strategies::Soaked;
use crate::subject::{Orders, Outcome, Pass, Subject};

/// The ports of a host, with the lock that is soaked.
#[derive(Debug)]
pub(crate) struct Ports<S>(PhantomData<fn() -> S>);

impl<S: Strategy> Platform for Ports<S> {
    type Strategy = S;
    type Clock = MonotonicClock;
    type Lane = NoLane;
    type Containment = Caught;
}

/// Tickets are kept until the program ends.
#[derive(Debug)]
struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
}

type Paper<S, D> = faregate::tickets::Ticket<'static, D, Ports<S>, Nobody>;

/// A gate with some tickets, and who is its tenant.
struct Post<S: Strategy, D: Driver + 'static> {
    key: Key<'static>,
    agent: &'static Scope,
    broker: &'static Scope,
    /// Twins of what the holders have, with the standing of both.
    grants: Vec<(Paper<S, D>, &'static Standing)>,
    tenure: usize,
    tenant: usize,
}

impl<S: Strategy, D: Driver + 'static> Post<S, D> {
    /// A gate with so many tickets, and a second ticket of each grant.
    fn new(
        room: &'static Room,
        broker: &'static Scope,
        tickets: u16,
    ) -> Outcome<(Self, Vec<Paper<S, D>>)> {
        let gate = Gate::<_, Ports<S>>::new(D::new(room), MonotonicClock::new(), NoLane);
        let (key, handle) = Box::leak(Box::new(gate)).key().split();
        let agent: &Scope = Box::leak(Box::default());
        let (mut grants, mut twins) = (Vec::new(), Vec::new());
        for seat in 0..tickets {
            let standing: &Standing = Box::leak(Box::default());
            let id = TicketId { seat, serial: usize::from(seat) + 1 };
            standing.seat(id.serial, 1);
            let seat = Seat { id, gate: GateId(0), standing, agent, broker };
            let ticket = || key.ticket(handle, seat, &Nobody).ok_or("the handle is another gate's");
            grants.push((ticket()?, standing));
            twins.push(ticket()?);
        }
        Ok((Self { key, agent, broker, grants, tenure: 0, tenant: 0 }, twins))
    }

    /// Makes this grant the tenant, and valid.
    fn admit(&mut self, grant: usize) -> Outcome<()> {
        let (ticket, standing) = &self.grants[grant];
        let stamp = Stamp { own: standing.epoch_seen(), broker: self.broker.read().epoch };
        let admission = Admission {
            serial: ticket.id().serial,
            tenure: self.tenure,
            agent: self.agent.read().epoch,
            validity: Validity::always(),
            stamp: Some((standing, stamp)),
        };
        let admitted = self.key.admit(admission, PATIENCE);
        self.tenure = admitted.map_err(|blocked| format!("not admitted: {blocked:?}"))?;
        self.tenant = grant;
        Ok(())
    }

    fn is_valid(&self) -> bool {
        self.grants[self.tenant].0.check().is_ok()
    }
}

/// How an agent or a supervisor revokes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Preempt,
    Bar,
    AgentSafeMode,
    BrokerSafeMode,
    AllButMe,
}

const WAYS: [Way; 5] =
    [Way::Preempt, Way::Bar, Way::AgentSafeMode, Way::BrokerSafeMode, Way::AllButMe];

/// One gate behind the strategy `S` with a driver `D`, and who revokes its
/// tickets.
pub(crate) struct Gates<S: Strategy, D: Driver + 'static> {
    rooms: [&'static Room; 1],
    post: Post<S, D>,
    /// Where the revoker has a ticket of its own, for all but me.
    own: Post<S, D>,
    passes: Vec<GatePass<S, D>>,
    way: Way,
    by_passing: bool,
    next: usize,
}

impl<S: Strategy, D: Driver + 'static> Gates<S, D> {
    pub(crate) fn new() -> Outcome<Self>
    where
        S: Soaked,
    {
        S::check()?;
        let room = Room::leaked();
        let broker: &Scope = Box::leak(Box::default());
        let (mut post, tickets) = Post::new(room, broker, 2)?;
        let (own, _) = Post::new(Room::leaked(), broker, 1)?;
        let passes = (1..).zip(tickets).map(|(holder, ticket)| GatePass { holder, room, ticket });
        let passes = passes.collect();
        room.open_for(1);
        post.admit(0)?;
        let (way, by_passing) = (Way::Preempt, false);
        Ok(Self { rooms: [room], post, own, passes, way, by_passing, next: 0 })
    }
}

impl<S: Strategy, D: Driver + 'static> Subject for Gates<S, D> {
    type Pass = GatePass<S, D>;

    fn orders(&self) -> Orders {
        D::ORDERS
    }

    fn rooms(&self) -> &[&'static Room] {
        &self.rooms
    }

    fn hand_out(&mut self) -> Vec<GatePass<S, D>> {
        std::mem::take(&mut self.passes)
    }

    fn aim(&mut self, dice: &mut Dice) -> Outcome<u32> {
        self.way = WAYS[dice.index(WAYS.len())];
        self.by_passing = dice.below(2) == 0;
        if self.way == Way::AllButMe && !self.own.is_valid() {
            self.own.admit(0)?;
        }
        Ok(1)
    }

    fn revoke(&mut self) -> Outcome<()> {
        let Post { grants, tenant, agent, broker, .. } = &self.post;
        let (ticket, standing) = &grants[*tenant];
        ticket.check().map_err(|refusal| format!("revoked what was not valid: {refusal}"))?;
        let (floor, by) = (Priority::EMERGENCY, self.own.grants[0].0.id());
        let mut survived = true;
        match self.way {
            Way::Preempt => standing.revoke(Why::Preempted { by, priority: floor }),
            Way::Bar => standing.bar(ticket.id().serial),
            Way::AgentSafeMode => agent.enter_safe_mode(floor),
            Way::BrokerSafeMode => broker.enter_safe_mode(floor),
            Way::AllButMe => survived = self.own.grants[0].0.revoke_all_but_me(broker, floor),
        }
        if !survived {
            return Err("all but me: the revoker's own ticket was revoked too".into());
        }
        if ticket.check().is_ok() {
            return Err(format!("{:?}: the ticket is still valid", self.way).into());
        }
        Ok(())
    }

    fn quiesce(&mut self) -> Outcome<()> {
        let hung = |blocked| format!("not quiescent: {blocked:?}");
        if self.by_passing {
            return Ok(self.post.key.pass(PATIENCE).map_err(hung)?);
        }
        self.post.tenure = self.post.key.vacate(self.post.tenure, PATIENCE).map_err(hung)?.tenure;
        Ok(())
    }

    fn next(&mut self, _: usize, dice: &mut Dice) -> u8 {
        self.next = dice.index(self.post.grants.len());
        u8::try_from(self.next + 1).unwrap_or(u8::MAX)
    }

    fn admit(&mut self) -> Outcome<()> {
        match self.way {
            Way::AgentSafeMode => self.post.agent.leave_safe_mode(),
            Way::BrokerSafeMode | Way::AllButMe => self.post.broker.leave_safe_mode(),
            Way::Preempt | Way::Bar => {}
        }
        self.post.admit(self.next)
    }
}

/// A holder's ticket.
pub(crate) struct GatePass<S: Strategy, D: Driver + 'static> {
    holder: u8,
    room: &'static Room,
    ticket: Paper<S, D>,
}

impl<S: Strategy, D: Driver + 'static> Pass for GatePass<S, D> {
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
