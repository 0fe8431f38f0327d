//! Whoever knows a ticket's number cannot give it back for its holder.

use bench::Switch;
use faregate_tickets::id::Priority;
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::Standing;
use faregate_tickets::ticket::{Holder, Issuer, Seat};

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let ticket = broker.request(Priority::SCIENCE, &lamp).unwrap();
    broker.service();
    let (standing, scope) = (Standing::new(), Scope::new());
    let (id, gate) = (ticket.id(), lamp.gate());
    let made_up = Seat { id, gate, standing: &standing, agent: &scope, broker: &scope };
    broker.relinquish(&ticket.seat, faregate_tickets::recorder::Unrecorded::default(), Holder::Lives); //~ E0616: `seat`
    broker.service();
    assert_eq!(ticket.invoke(Switch::On), Ok(true));
}
