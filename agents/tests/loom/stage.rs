//! One gate and its key, without an agent: the model decides.

use faregate_tickets::Gate;
use faregate_tickets::clock::Duration;
use faregate_tickets::gate::{Admission, Blocked, Handle, Key};
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::interlock::Member;
use faregate_tickets::lock::{LoomLocked, Strategy};
use faregate_tickets::recorder::NoLane;
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::{Stamp, Standing};
use faregate_tickets::ticket::{Issuer, Seat};
use faregate_tickets::validity::Validity;

use crate::lamp::{Given, Lamp, Loomed, Ticks};
use crate::model::keep;

pub(crate) type Ticket<S = LoomLocked> = faregate_tickets::Ticket<'static, Lamp, Loomed<S>, Nobody>;

/// To whom tickets of a stage go back.
#[derive(Debug)]
pub(crate) struct Nobody;

impl Issuer for Nobody {
    fn relinquish(
        &self,
        _: &Seat<'_>,
        _: faregate_tickets::recorder::Unrecorded,
        _: faregate_tickets::ticket::Holder,
    ) {
    }
}

/// A gate with two holders, 0 and 1. Their serials are 1 and 2.
pub(crate) struct Stage<S: Strategy = LoomLocked> {
    pub(crate) key: Key<'static>,
    pub(crate) standings: [Standing; 2],
    handle: Handle<'static, Lamp, Loomed<S>>,
    agent: Scope,
    pub(crate) broker: Scope,
}

/// Time does not pass in a model.
pub(crate) const PATIENCE: Duration = Duration::MAX;

impl Stage {
    pub(crate) fn new(hardware: impl FnMut(Given) + Send + 'static) -> &'static Self {
        Self::of(Lamp::new(1, hardware))
    }

    pub(crate) fn interlocked(
        member: Member<'static>,
        hardware: impl FnMut(Given) + Send + 'static,
    ) -> &'static Self {
        Self::behind(keep(gate(Lamp::new(1, hardware)).interlocked(member)))
    }
}

impl<S: Strategy> Stage<S> {
    pub(crate) fn of(lamp: Lamp) -> &'static Self {
        Self::behind(keep(gate(lamp)))
    }

    fn behind(gate: &'static mut Gate<'static, Lamp, Loomed<S>>) -> &'static Self {
        let (key, handle) = gate.key().split();
        let standings = [Standing::new(), Standing::new()];
        for (serial, standing) in (1..).zip(&standings) {
            standing.seat(serial, 1);
        }
        keep(Self { key, standings, handle, agent: Scope::new(), broker: Scope::new() })
    }

    pub(crate) fn ticket(&'static self, holder: usize) -> Ticket<S> {
        let seat = Seat {
            id: TicketId { seat: 0, serial: holder + 1 },
            gate: GateId(0),
            standing: &self.standings[holder],
            agent: &self.agent,
            broker: &self.broker,
        };
        self.key.ticket(self.handle, seat, &Nobody).expect("the handle is this gate's")
    }

    /// Makes the holder the tenant, with stamps that have not been revoked.
    pub(crate) fn admit(&self, holder: usize, tenure: usize) -> Result<usize, Blocked> {
        self.admit_with(holder, tenure, Validity::always())
    }

    pub(crate) fn admit_with(
        &self,
        holder: usize,
        tenure: usize,
        validity: Validity,
    ) -> Result<usize, Blocked> {
        self.admit_by(holder, tenure, validity, 1)
    }

    /// With the broker's epoch that was read before the decision.
    pub(crate) fn admit_at(
        &self,
        holder: usize,
        tenure: usize,
        broker: usize,
    ) -> Result<usize, Blocked> {
        self.admit_by(holder, tenure, Validity::always(), broker)
    }

    fn admit_by(
        &self,
        holder: usize,
        tenure: usize,
        validity: Validity,
        broker: usize,
    ) -> Result<usize, Blocked> {
        let stamp = Some((&self.standings[holder], Stamp { own: 1, broker }));
        let admission = Admission { serial: holder + 1, tenure, agent: 1, validity, stamp };
        self.key.admit(admission, PATIENCE)
    }
}

fn gate<S: Strategy>(lamp: Lamp) -> Gate<'static, Lamp, Loomed<S>> {
    let clock: &'static Ticks = keep(Ticks::default());
    Gate::new(lamp, clock, NoLane)
}
