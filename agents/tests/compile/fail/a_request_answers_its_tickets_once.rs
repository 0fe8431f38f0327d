//! Whoever knows a ticket's number has no tickets made for it: only its request had.

use bench::Switch;
use faregate_agents::Wants;
use faregate_tickets::id::Priority;

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let first = broker.request(Priority::EMERGENCY, &lamp).unwrap();
    let second = lamp.tickets(&broker, &first.id()).unwrap(); //~ E0308: `&Seated`, `&TicketId`
    broker.service();
    assert_eq!(first.invoke(Switch::On), Ok(true));
    assert!(second.invoke(Switch::Off).is_err());
}
