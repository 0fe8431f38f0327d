//! While a gate's key exists there is no other.

use faregate_tickets::id::Priority;

fn main() {
    let (mut gate, mut spare) = (bench::gate(), bench::gate());
    let (mut broker, agent) = bench::broker();
    let first = gate.key();
    let second = spare.key();
    let one = broker.register(agent, first).unwrap();
    let other = broker.register(agent, second).unwrap();
    assert_ne!(one.gate(), other.gate());
}
