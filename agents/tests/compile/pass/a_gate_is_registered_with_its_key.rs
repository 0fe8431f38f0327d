//! Whoever may request tickets for a gate cannot give the gate to an agent of its
//! own.

use faregate_agents::RequestRefused;
use faregate_tickets::id::Priority;

fn main() {
    let (mut gate, mut spare) = (bench::gate(), bench::gate());
    let (mut broker, agent) = bench::broker();
    let (mut intruder, own_agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let own = intruder.register(own_agent, spare.key()).unwrap();
    assert!(intruder.request(Priority::SCIENCE, &own).is_ok());
    let foreign = intruder.request(Priority::SCIENCE, &lamp);
    assert_eq!(foreign.unwrap_err(), RequestRefused::UnknownGate);
}
