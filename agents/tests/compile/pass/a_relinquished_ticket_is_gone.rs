//! Whoever gave a ticket back asks for another one.

use bench::Switch;
use faregate_tickets::id::Priority;

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let ticket = broker.request(Priority::SCIENCE, &lamp).unwrap();
    broker.service();
    let next = broker.request(Priority::SCIENCE, &lamp).unwrap();
    assert_eq!(ticket.invoke(Switch::On), Ok(true));

    ticket.relinquish();
    broker.service();
    assert_eq!(next.invoke(Switch::Off), Ok(false));
}
