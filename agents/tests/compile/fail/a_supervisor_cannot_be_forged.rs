//! Whoever revokes what is not theirs has a supervisor, and the broker made it.

use faregate_agents::Supervisor;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let supervisor = Supervisor { tag: 1, agent: None }; //~ E0451: `tag`, `agent`
    let ticket = broker.request(Priority::SCIENCE, &lamp).unwrap();
    broker.service();
    assert_eq!(ticket.check(), Ok(()));

    broker.bar(&supervisor, ticket.id()).unwrap().quiesce().unwrap();
    assert_eq!(ticket.check(), Err(Refusal::NotValid(Why::Barred)));
}
