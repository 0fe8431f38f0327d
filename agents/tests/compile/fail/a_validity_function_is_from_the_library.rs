//! The audit saw every validity function that there can be.

use bench::Switch;
use faregate_tickets::id::Priority;
use faregate_tickets::validity::{Ask, Denial, Function};

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let once = lamp.limited(|_: &Ask<'_>| Ok::<(), Denial>(())); //~ E0277: `Validity: From<
    let ticket = broker.request(Priority::SCIENCE, &once).unwrap();
    broker.service();
    assert_eq!(ticket.invoke(Switch::On), Ok(true));
    assert!(ticket.invoke(Switch::Off).is_err());
}
