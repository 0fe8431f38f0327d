//! Only a key makes tickets: the parts of one do not make it.

use bench::{Platform, Switch};
use faregate_tickets::clock::Duration;
use faregate_tickets::gate::Admission;
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::{Stamp, Standing};
use faregate_tickets::ticket::{Issuer, Seat, Ticket};
use faregate_tickets::validity::Validity;

struct Nobody;

impl Issuer for Nobody {
    fn relinquish(&self, _: &Seat<'_>, _: faregate_tickets::recorder::Unrecorded, _: faregate_tickets::ticket::Holder) {}
}

fn main() {
    let (mut gate, open) = (bench::gate(), bench::gate());
    let (standing, agent, broker) = (Standing::new(), Scope::new(), Scope::new());
    let id = TicketId { seat: 0, serial: 1 };
    standing.seat(id.serial, 1);
    let (standing, agent, broker) = (&standing, &agent, &broker);
    let seat = Seat { id, gate: GateId(0), standing, agent, broker };
    let (key, handle) = gate.key().split();
    let ticket = Ticket::new(&open, seat, &Nobody); //~ E0624: `new`

    let own = Stamp { own: standing.epoch_seen(), broker: broker.read().epoch };
    let admission = Admission {
        serial: id.serial,
        tenure: 0,
        agent: agent.read().epoch,
        validity: Validity::always(),
        stamp: Some((standing, own)),
    };
    key.admit(admission, Duration::ZERO).unwrap();
    assert_eq!(ticket.invoke(Switch::On), Ok(true));
}
