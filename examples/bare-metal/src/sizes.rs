//! What the parts take of a small chip's memory, as the compiler laid them out.

use faregate_agents::{Actions, Broker};
use faregate_tickets::Gate;
use semihosting::println;

use crate::craft::{Camera, Craft, CraftBroker, GATES, Pend, Ports, TICKETS, TicketFor};
use crate::{Failure, claim, sys};

/// Brokers that differ from ours by one gate, one ticket, one set.
type OneGateMore = Broker<'static, Ports, Pend, { GATES + 1 }, TICKETS, 0>;
type OneTicketMore = Broker<'static, Ports, Pend, GATES, { TICKETS + 1 }, 0>;
type OneSetMore = Broker<'static, Ports, Pend, GATES, TICKETS, 1>;
/// What there is whatever the mission.
type Least = Broker<'static, Ports, Pend, 1, 1, 0>;

pub(crate) fn print() -> Result<(), Failure> {
    const BROKER: usize = size_of::<CraftBroker>();
    println!("bytes of memory");
    for (bytes, what) in [
        (BROKER, "the broker, for 3 gates and 8 tickets"),
        (size_of::<Least>(), "a broker for one gate and one ticket"),
        (size_of::<OneGateMore>() - BROKER, "each gate more, in the broker"),
        (size_of::<OneTicketMore>() - BROKER, "each ticket more, in the broker"),
        (size_of::<OneSetMore>() - BROKER, "each set more, in the broker"),
        (size_of::<Gate<'static, Camera, Ports>>(), "a gate, driver included"),
        (size_of::<TicketFor<Camera>>(), "a ticket, with its holder"),
        (size_of::<Actions<GATES>>(), "what a step answers, for 3 gates"),
        (size_of::<Craft>(), "the handles that the threads share"),
    ] {
        println!("  {bytes:>6}  {what}");
    }
    let (most, all) = sys::most_stack();
    println!("  {most:>6}  most that was used of the stack, interrupts included");
    claim(most < all, "the stack has room for every interrupt")
}
