//! The least that an agent does: it admits tickets to one gate, and takes them
//! back. What is measured with it is the gate, and no policy.

use faregate::prelude::{Priority, TicketId, Validity, Why};
use faregate::tickets::gate::{Admission, Blocked, Key};
use faregate::tickets::id::GateId;
use faregate::tickets::recorder::Unrecorded;
use faregate::tickets::scope::Scope;
use faregate::tickets::standing::{Stamp, Standing};
use faregate::tickets::ticket::{Holder, Issuer, Seat};

use super::Outcome;
use super::device::Patience;
use super::stage::Answer;

/// Takes tickets back, and keeps no books.
pub(crate) struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
}

/// The seats of two tickets for one gate.
#[derive(Default)]
pub(crate) struct Seats {
    standings: [Standing; 2],
    agent: Scope,
    broker: Scope,
}

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    First,
    Second,
}

impl Place {
    fn id(self) -> TicketId {
        match self {
            Self::First => TicketId { seat: 0, serial: 1 },
            Self::Second => TicketId { seat: 1, serial: 2 },
        }
    }
}

impl Seats {
    pub(crate) fn new() -> Self {
        let seats = Self::default();
        for place in [Place::First, Place::Second] {
            seats.standing(place).seat(place.id().serial, 1);
        }
        seats
    }

    fn standing(&self, place: Place) -> &Standing {
        let [first, second] = &self.standings;
        match place {
            Place::First => first,
            Place::Second => second,
        }
    }

    pub(crate) fn seat(&self, place: Place) -> Seat<'_> {
        let standing = self.standing(place);
        let (agent, broker) = (&self.agent, &self.broker);
        Seat { id: place.id(), gate: GateId(0), standing, agent, broker }
    }
}

/// Decides who is admitted to the gate.
pub(crate) struct Desk<'g> {
    key: Key<'g>,
    seats: &'g Seats,
    patience: Patience,
    tenure: usize,
}

impl<'g> Desk<'g> {
    pub(crate) fn new(key: Key<'g>, seats: &'g Seats, patience: Patience) -> Self {
        Self { key, seats, patience, tenure: 0 }
    }

    /// Begins a round: a gate that was given up is open again, and nobody's.
    pub(crate) fn begin(&mut self) -> Outcome<()> {
        self.key.reopen();
        [Place::First, Place::Second].into_iter().for_each(|place| self.revoke(place));
        match self.vacate()? {
            Answer::Done => Ok(()),
            Answer::GaveUp => Err("nobody is inside, and the gate does not open".into()),
        }
    }

    /// Makes the ticket in this place the gate's tenant, and valid.
    pub(crate) fn admit(&mut self, place: Place) -> Outcome<()> {
        let standing = self.seats.standing(place);
        let own = standing.epoch_seen();
        let stamp = Stamp { own, broker: self.seats.broker.read().epoch };
        let admission = Admission {
            serial: place.id().serial,
            tenure: self.tenure,
            agent: self.seats.agent.read().epoch,
            validity: Validity::always(),
            stamp: Some((standing, stamp)),
        };
        let patience = self.patience.duration();
        self.tenure = self.key.admit(admission, patience).map_err(told)?;
        Ok(())
    }

    /// Revokes the ticket in this place. Nobody can delay it.
    pub(crate) fn revoke(&self, place: Place) {
        let why = Why::Preempted { by: Place::Second.id(), priority: Priority::EMERGENCY };
        self.seats.standing(place).revoke(why);
    }

    /// Waits until no command is in progress.
    pub(crate) fn vacate(&mut self) -> Outcome<Answer> {
        match self.key.vacate(self.tenure, self.patience.duration()) {
            Ok(vacated) => {
                self.tenure = vacated.tenure;
                Ok(Answer::Done)
            }
            Err(Blocked::Hung) => Ok(Answer::GaveUp),
            Err(blocked) => Err(told(blocked).into()),
        }
    }
}

fn told(blocked: Blocked) -> String {
    format!("the gate is blocked: {blocked:?}")
}
