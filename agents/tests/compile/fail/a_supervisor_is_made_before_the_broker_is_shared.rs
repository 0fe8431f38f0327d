//! A holder that has the broker for its requests makes no supervisor from it.

use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let made_before = broker.supervisor();
    let ticket = broker.request(Priority::SCIENCE, &lamp).unwrap();
    broker.service();
    let supervisor = broker.supervisor(); //~ E0502: `broker`
    assert_eq!(ticket.check(), Ok(()));

    broker.bar(&supervisor, ticket.id()).unwrap().quiesce().unwrap();
    assert_eq!(ticket.check(), Err(Refusal::NotValid(Why::Barred)));
}
