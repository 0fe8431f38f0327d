//! Rows of our gates, behind one strategy or another.

use std::sync::Arc;

use faregate::runtime::clock::MonotonicClock;
use faregate::runtime::host::{HostFenced, HostStrategy};
use faregate::tickets::gate::{Gate, Handle};
use faregate::tickets::lock::{Locked, Strategy};
use faregate::tickets::recorder::NoLane;
use faregate::tickets::refusal::{InvokeError, Refusal};
use faregate::tickets::ticket::Ticket;

use super::Outcome;
use super::desk::{Desk, Nobody, Place, Seats};
use super::device::{Driver, Order, Patience};
use super::measured::Measured;
use super::probe::{Probed, stalling};
use super::stage::{Answer, Cue, Limits, Revoker, Stage};

/// The strategy of plain hosts.
pub(crate) type ParkingLot = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

type Ports<S> = (S, MonotonicClock, NoLane);
type Pass<'g, S> = Ticket<'g, Driver, Ports<S>, Nobody>;

/// A strategy that has rows.
pub(crate) trait Behind: Strategy {
    /// How long its waiters wait.
    const PATIENCE: Patience = Patience::Long;
}

impl Behind for HostStrategy {}
impl Behind for ParkingLot {}
impl Behind for HostFenced {
    const PATIENCE: Patience = Patience::Short;
}
impl<S: Behind> Behind for Probed<S> {
    const PATIENCE: Patience = S::PATIENCE;
}

/// From the revocation until quiescence, while the holder is inside a command.
pub(crate) fn inside_command<S: Behind>(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    with_gate::<S>(stage, |desk, ticket, _| {
        let command = move || {
            // Where the gate has a way of its own for its tenant, this opens it.
            ticket.invoke(Order::Store(0))?;
            Ok(ticket.invoke(Order::BePreempted)?)
        };
        stage.play(Cue::Inside, limits, command, Revoke(desk))
    })
}

/// The same at any instant of a holder that commands all the time, each command
/// one store.
pub(crate) fn any_instant<S: Behind>(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    with_gate::<S>(stage, |desk, ticket, _| {
        let mut number = 0_u32;
        let commands = move || {
            loop {
                number = number.wrapping_add(1);
                if ticket.invoke(Order::Store(number)).is_err() || stage.is_over() {
                    return Ok(());
                }
            }
        };
        stage.play(Cue::AnyInstant, limits, commands, Revoke(desk))
    })
}

/// How long a valid command takes while a refused holder is inside its check.
///
/// Its ticket is valid when it looks at the gate, and no more when it
/// enters: it stalls in between, which is the only way for a refused command
/// to come inside.
pub(crate) fn inside_check<S: Behind>(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    with_gate::<Probed<S>>(stage, |desk, refused, valid| {
        let check = move || {
            // Where the gate has a way of its own for its tenant, this opens it.
            refused.invoke(Order::Store(0))?;
            let result = stalling(stage, || refused.invoke(Order::StoreInSteps(1)));
            let refused = result.is_err_and(|error| error.refusal().is_some());
            if refused { Ok(()) } else { Err("a revoked command was issued".into()) }
        };
        stage.play(Cue::InsideAfterStall, limits, check, Overtake { desk, valid })
    })
}

/// Makes a gate, and two tickets for it.
fn with_gate<S: Behind>(
    stage: &Arc<Stage>,
    row: impl for<'g> FnOnce(Desk<'g>, Pass<'g, S>, Pass<'g, S>) -> Outcome<Measured>,
) -> Outcome<Measured> {
    let driver = Driver { stage: Arc::clone(stage), patience: S::PATIENCE };
    let mut gate = Gate::<_, Ports<S>>::new(driver, MonotonicClock::new(), NoLane);
    let seats = Seats::new();
    let (key, handle): (_, Handle<'_, _, _>) = gate.key().split();
    let ticket = |place| key.ticket(handle, seats.seat(place), &Nobody);
    let tickets = ticket(Place::First).zip(ticket(Place::Second));
    let (first, second) = tickets.ok_or("the handle is another gate's")?;
    row(Desk::new(key, &seats, S::PATIENCE), first, second)
}

/// Revokes the holder's ticket, until quiescent.
struct Revoke<'g>(Desk<'g>);

impl Revoker for Revoke<'_> {
    fn prepare(&mut self) -> Outcome<()> {
        self.0.begin()?;
        self.0.admit(Place::First)
    }

    fn measured(&mut self) -> Outcome<Answer> {
        self.0.revoke(Place::First);
        self.0.vacate()
    }
}

/// Has taken the holder's place, and commands.
struct Overtake<'g, S: Behind> {
    desk: Desk<'g>,
    valid: Pass<'g, S>,
}

impl<S: Behind> Revoker for Overtake<'_, S> {
    fn prepare(&mut self) -> Outcome<()> {
        self.desk.begin()?;
        self.desk.admit(Place::First)
    }

    fn meanwhile(&mut self) -> Outcome<()> {
        self.desk.begin()?;
        self.desk.admit(Place::Second)
    }

    fn measured(&mut self) -> Outcome<Answer> {
        match self.valid.invoke(Order::StoreInSteps(2)) {
            Ok(()) => Ok(Answer::Done),
            Err(InvokeError::Refused(Refusal::Busy)) => Ok(Answer::GaveUp),
            Err(error) => Err(error.into()),
        }
    }
}
