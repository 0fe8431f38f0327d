//! Two holders need two tickets, of which a gate admits one.

use bench::Switch;
use faregate_tickets::id::Priority;

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let first = broker.request(Priority::SCIENCE, &lamp).unwrap();
    let second = Clone::clone(&first); //~ E0277: `Clone`, `Ticket<
    broker.service();
    assert_eq!(first.invoke(Switch::On), Ok(true));
    assert!(second.invoke(Switch::Off).is_err());
}
