//! A gate does not hand out what it guards.

use bench::Switch;
use faregate_tickets::id::Priority;

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let ticket = broker.request(Priority::SCIENCE, &lamp).unwrap();
    broker.service();
    gate.inside.with(|inside| inside.driver.issue(Switch::On)).unwrap(); //~ E0616: `inside`
    assert_eq!(ticket.invoke(Switch::Look), Ok(true));
}
