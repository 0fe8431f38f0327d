//! A ticket has one holder: it moves to another thread, or stays.

use bench::Switch;
use faregate_tickets::id::Priority;
use std::thread;

fn main() {
    let mut gate = bench::gate();
    let (mut broker, agent) = bench::broker();
    let lamp = broker.register(agent, gate.key()).unwrap();
    let ticket = broker.request(Priority::SCIENCE, &lamp).unwrap();
    broker.service();
    thread::scope(|scope| {
        let holder = scope.spawn(|| ticket.invoke(Switch::On)); //~ E0277: `Sync`, `Cell<u32>`
        assert_eq!(holder.join().unwrap(), Ok(true));
    });
}
