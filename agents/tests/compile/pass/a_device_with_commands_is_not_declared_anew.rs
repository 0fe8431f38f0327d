//! What a command may draw was declared when its gate was made, and stays so.

use std::convert::Infallible;

use bench::{LampBroker, Platform, Stopped};
use faregate_agents::{Categories, Policy, Redeclared};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::{Declaration, Device, Effect, Profile};
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;

struct Place;

impl Device for Place {
    type Command = Infallible;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new()
    }
    fn declare(_: &Self::Command) -> Declaration {
        Declaration { code: 0, wcet: Duration::from_millis(1), effect: Effect::Unchanged }
    }
    fn issue(&mut self, _: Self::Command) -> Result<(), ()> {
        Ok(())
    }
    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }
}

fn main() {
    let mut gate = faregate_tickets::Gate::<_, Platform>::new(Place, Stopped, NoLane);
    let mut broker = LampBroker::new(Stopped, NoLane, NoNotify);
    let agent = broker.agent(Policy::power_margin(Milliwatts::from_watts(9))).unwrap();
    let place = broker.register(agent, gate.key()).unwrap();
    let (draw, categories) = (Milliwatts::from_watts(9), Categories::NONE);
    let (settling, estimate_lag) = (Duration::ZERO, Duration::from_millis(1));
    let declared = Redeclared { draw, categories, settling, estimate_lag };
    let refused = broker.redeclare(&place, &declared).unwrap_err();
    assert_eq!(refused.to_string(), "the device may be on; it must be seen off first");
    assert_eq!(broker.now(), Some(Instant::START));
}
