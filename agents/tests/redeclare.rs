//! A device without commands can be declared anew, while nobody asks for it and
//! it is known to be off.

mod bench;

use std::convert::Infallible;

use bench::{Hands, Kit, LampHandle, TICK, Tape, TestBroker, drawing, leak, watts};
use faregate_agents::{
    AgentId, Categories, Handle, NotRedeclared, Policy, Redeclared, RequestRefused, Supervisor,
    Waiting,
};
use faregate_tickets::Gate;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Declaration, Device, Estimate, Power, Profile};
use faregate_tickets::id::Priority;
use faregate_tickets::validity::Validity;

/// A place that something runs in. It has no commands; others turn it on.
struct Place(Profile);

impl Device for Place {
    type Command = Infallible;
    type Response = Infallible;
    type Fault = Infallible;

    fn profile(&self) -> Profile {
        self.0
    }
    fn declare(command: &Infallible) -> Declaration {
        match *command {}
    }
    fn issue(&mut self, command: Infallible) -> Result<Infallible, Infallible> {
        match command {}
    }
    fn safe(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

type PlaceHandle = Handle<'static, Place, bench::Platform>;

struct World {
    broker: &'static TestBroker,
    clock: &'static Hands,
    agent: AgentId,
    place: PlaceHandle,
    lamp: LampHandle,
    supervisor: Supervisor,
}

const CAMERA: Categories = Categories::from_mask(1);

/// A place without draw, and a lamp with a category and 8 W, on 10 W.
fn world() -> World {
    let mut kit = Kit::new();
    let agent = kit.agent(Policy::power_margin(watts(10)).with_categories());
    let tape: &'static Tape = leak(Tape::default());
    let mut profile = Profile::new();
    profile.lease = Duration::MAX;
    let gate = leak(Gate::<_, bench::Platform>::new(Place(profile), kit.clock, tape));
    let place = kit.broker.register(agent, gate.key()).unwrap();
    kit.fitted(agent, drawing(8), CAMERA, |gate| gate);
    let supervisor = kit.broker.supervisor();
    let Kit { broker, clock, lamps, .. } = kit;
    let broker = Box::leak(broker);
    let world = World { broker, clock, agent, place, lamp: lamps[0], supervisor };
    world.see(world.lamp.gate(), Power::Off);
    world
}

impl World {
    fn see(&self, gate: faregate_tickets::id::GateId, state: Power) {
        self.clock.advance(TICK);
        self.broker.observe(gate, Estimate { state, measured_at: self.clock.now() });
        self.broker.service();
    }

    fn redeclare(&self, draw: u32, categories: Categories) -> Result<(), NotRedeclared> {
        let (settling, estimate_lag) = (Duration::ZERO, Duration::from_millis(5));
        let draw = watts(draw);
        self.broker.redeclare(&self.place, &Redeclared { draw, categories, settling, estimate_lag })
    }

    fn charged(&self) -> u64 {
        self.broker.margin(self.agent).unwrap().1.get() / 1000
    }
}

#[test]
fn what_is_asked_for_is_judged_by_what_is_declared_last() {
    let world = world();
    world.see(world.place.gate(), Power::Off);
    world.redeclare(11, Categories::NONE).unwrap();
    let refused = world.broker.request(Priority::SCIENCE, &world.place).unwrap_err();
    assert_eq!(refused, RequestRefused::OverSupply { draw: watts(11), supply: watts(10) });
    world.redeclare(4, Categories::NONE).unwrap();
    let place = world.broker.request(Priority::SCIENCE, &world.place).unwrap();
    world.broker.service();
    assert_eq!((place.check(), world.charged()), (Ok(()), 4));
    let lamp = world.broker.request(Priority::LEAST, &world.lamp).unwrap();
    let short_by = Some(Waiting::Margin { short_by: watts(2) });
    assert_eq!(world.broker.waiting_for(lamp.id()), short_by);
}

#[test]
fn categories_declared_anew_keep_two_from_running_together() {
    let world = world();
    world.see(world.place.gate(), Power::Off);
    world.redeclare(0, CAMERA).unwrap();
    let place = world.broker.request(Priority::SCIENCE, &world.place).unwrap();
    let lamp = world.broker.request(Priority::LEAST, &world.lamp).unwrap();
    world.broker.service();
    assert_eq!((place.check().is_ok(), lamp.check().is_ok()), (true, false));
}

#[test]
fn a_device_that_may_be_on_is_not_declared_anew() {
    let world = world();
    assert_eq!(world.redeclare(4, CAMERA), Err(NotRedeclared::MayBeOn), "never seen off");
    world.see(world.place.gate(), Power::Off);
    assert_eq!(world.redeclare(4, CAMERA), Ok(()));
    let place = world.broker.request(Priority::SCIENCE, &world.place).unwrap();
    world.broker.service();
    world.see(world.place.gate(), Power::On);
    drop(place);
    world.broker.service();
    assert_eq!(world.redeclare(2, CAMERA), Err(NotRedeclared::MayBeOn), "charged");
    assert_eq!(world.charged(), 4);
    world.see(world.place.gate(), Power::Off);
    assert_eq!((world.redeclare(2, CAMERA), world.charged()), (Ok(()), 0));
}

#[test]
fn a_device_that_was_not_charged_is_seen_off_before_it_is() {
    let world = world();
    world.see(world.place.gate(), Power::Off);
    let place = world.broker.request(Priority::SCIENCE, &world.place).unwrap();
    world.broker.service();
    world.see(world.place.gate(), Power::On);
    drop(place);
    world.broker.service();
    assert_eq!(world.charged(), 0, "it counts as off");
    assert_eq!(world.redeclare(4, CAMERA), Err(NotRedeclared::MayBeOn), "and it is on");
    world.see(world.place.gate(), Power::Off);
    assert_eq!(world.redeclare(4, CAMERA), Ok(()));
}

#[test]
fn nothing_changes_under_a_ticket_that_waits_or_is_barred() {
    let world = world();
    world.see(world.place.gate(), Power::Off);
    world.redeclare(4, CAMERA).unwrap();
    let lamp = world.broker.request(Priority::EMERGENCY, &world.lamp).unwrap();
    let place = world.broker.request(Priority::SCIENCE, &world.place).unwrap();
    world.broker.service();
    let requested = Err(NotRedeclared::Requested { by: place.id() });
    assert_eq!(world.redeclare(2, CAMERA), requested);
    let before = world.broker.books();
    world.broker.bar(&world.supervisor, place.id()).unwrap().without_waiting();
    world.broker.service();
    assert_eq!(world.redeclare(2, CAMERA), requested);
    assert_ne!(world.broker.books(), before, "the bar was taken in");
    drop((lamp, place));
    world.broker.service();
    assert_eq!(world.redeclare(2, CAMERA), Ok(()));
}

#[test]
fn another_brokers_gate_is_unknown() {
    let (world, other) = (world(), world());
    let declared = Redeclared {
        draw: watts(1),
        categories: Categories::NONE,
        settling: Duration::ZERO,
        estimate_lag: TICK,
    };
    let refused = other.broker.redeclare(&world.place, &declared);
    assert_eq!(refused, Err(NotRedeclared::UnknownGate));
}

#[test]
fn a_ticket_whose_device_declares_no_lease_does_not_end_by_itself() {
    let world = world();
    world.see(world.place.gate(), Power::Off);
    world.redeclare(4, CAMERA).unwrap();
    let place = world.broker.request(Priority::SCIENCE, &world.place).unwrap();
    world.broker.service();
    world.clock.advance(Duration::from_secs(100 * 365 * 86_400));
    assert_eq!((world.broker.service(), place.check()), (None, Ok(())));
}

/// The control: the same ticket with a lease ends.
#[test]
fn a_ticket_whose_device_declares_a_lease_ends_with_it() {
    let world = world();
    let lamp = world.broker.request(Priority::SCIENCE, &world.lamp).unwrap();
    world.broker.service();
    assert_eq!(lamp.check(), Ok(()));
    world.clock.advance(Duration::from_secs(100 * 365 * 86_400));
    world.broker.service();
    assert!(lamp.check().is_err());
}

fn list<const N: usize>(
    lamps: &[LampHandle],
) -> heapless::Vec<faregate_agents::Want<'static, bench::Lamp, bench::Platform>, N> {
    lamps.iter().map(|lamp| lamp.limited(Validity::always())).collect()
}

#[test]
fn a_list_is_granted_all_or_nothing() {
    let (bench, _) = bench::Bench::new(bench::margin(14), &[6, 8, 6]);
    let holder = bench.ticket(9, 1);
    let request = |level, lamps: &[LampHandle]| {
        let tickets = bench.broker.request(Priority::new(level), &list::<4>(lamps));
        bench.broker.service();
        tickets
    };
    let both = request(5, &bench.lamps[..2]).unwrap();
    assert!(both.iter().all(|ticket| ticket.check().is_err()));
    drop(holder);
    bench.pass(TICK);
    assert!(both.len() == 2 && both.iter().all(|ticket| ticket.check().is_ok()));
    let one = request(6, &bench.lamps[2..]).unwrap();
    assert!(one[0].check().is_ok(), "a list of one is one");
    assert!(both.iter().all(|ticket| ticket.check().is_err()));
}

#[test]
fn a_list_of_no_gates_and_one_with_a_gate_twice_are_refused() {
    let (bench, _) = bench::Bench::new(bench::margin(14), &[6, 8]);
    let request =
        |lamps: &[LampHandle]| bench.broker.request(Priority::new(5), &list::<4>(lamps)).map(drop);
    assert_eq!(request(&[]), Err(RequestRefused::NoGate));
    let twice = RequestRefused::GateTwice(bench.lamps[0].gate());
    assert_eq!(request(&[bench.lamps[0], bench.lamps[0]]), Err(twice));
    assert_eq!(request(&bench.lamps), Ok(()));
}

#[test]
fn a_gate_beside_a_list_is_one_request() {
    let world = world();
    world.see(world.place.gate(), Power::Off);
    world.redeclare(4, CAMERA).unwrap();
    let place = || world.place.limited(Validity::always());
    let alone = (place(), list::<4>(&[]));
    let (ticket, none) = world.broker.request(Priority::SCIENCE, &alone).unwrap();
    world.broker.service();
    assert!(ticket.check().is_ok() && none.is_empty());
    drop(ticket);
    world.see(world.place.gate(), Power::Off);
    let asked = (place(), list::<4>(&[world.lamp]));
    let refused = world.broker.request(Priority::SCIENCE, &asked).map(drop).unwrap_err();
    assert_eq!(refused, RequestRefused::OverSupply { draw: watts(12), supply: watts(10) });
}
