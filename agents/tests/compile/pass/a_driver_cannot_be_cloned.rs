//! A driver is the only handle to its hardware.

use bench::{Platform, Stopped};
use faregate_tickets::Gate;
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::id::Priority;
use faregate_tickets::recorder::NoLane;
use std::convert::Infallible;

#[derive(Debug)]
struct Wire;

impl Device for Wire {
    type Command = ();
    type Response = &'static str;
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        Profile::new()
    }

    fn declare((): &()) -> Declaration {
        Declaration { code: 0, wcet: Duration::from_millis(1), effect: Effect::Unchanged }
    }

    fn issue(&mut self, (): ()) -> Result<&'static str, Infallible> {
        Ok("done")
    }

    fn safe(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

fn main() {
    let mut gate: Gate<'_, Wire, Platform> = Gate::new(Wire, Stopped, NoLane);
    let (mut broker, agent) = bench::broker();
    let wire = broker.register(agent, gate.key()).unwrap();
    let ticket = broker.request(Priority::SCIENCE, &wire).unwrap();
    broker.service();
    assert_eq!(ticket.invoke(()), Ok("done"));
}
