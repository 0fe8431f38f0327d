//! Whoever made the driver keeps no way to it.

use bench::{Gate, Lamp, Stopped, Switch};
use faregate_tickets::Device;
use faregate_tickets::id::Priority;
use faregate_tickets::recorder::NoLane;

fn main() {
    let mut lamp = Lamp::default();
    let kept = &mut Lamp::default();
    let mut gate = Gate::new(lamp, Stopped, NoLane);
    assert_eq!(kept.issue(Switch::On), Ok(true));

    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let ticket = broker.request(Priority::SCIENCE, &lamp).unwrap();
    broker.service();
    assert_eq!(ticket.invoke(Switch::Look), Ok(false), "the lamp behind the gate is another one");
}
