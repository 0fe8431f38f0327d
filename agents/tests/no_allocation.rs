//! **No Allocation**: once gates and broker are built, nothing allocates.

mod bench;
#[path = "no_allocation/sys.rs"]
mod sys;

use bench::{Caught, Hands, Lamp, Switch, TICK, Truth, drawing, leak, margin};
use faregate_agents::{Broker, Handle};
use faregate_tickets::amount::Microjoules;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::id::Priority;
use faregate_tickets::lock::Locked;
use faregate_tickets::notify::NoNotify;
use faregate_tickets::recorder::NoLane;
use faregate_tickets::validity::{Function, Validity};
use faregate_tickets::{Gate, Platform};
use sys::{ALLOCATIONS, Counting};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often this thread allocated meanwhile.
fn allocations(f: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.get();
    f();
    ALLOCATIONS.get() - before
}

/// A platform whose recorder keeps nothing: the test's own tape allocates.
#[derive(Debug)]
struct Silent;

impl Platform for Silent {
    type Strategy = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;
    type Clock = &'static Hands;
    type Lane = NoLane;
    type Containment = Caught;
}

type SilentBroker = Broker<'static, Silent, NoNotify, 4, 8, 2>;
type SilentLamp = Handle<'static, Lamp, Silent>;

#[test]
fn the_count_counts() {
    assert_eq!(allocations(|| drop(Box::new(1))), 1);
}

#[test]
fn nothing_allocates_after_construction() {
    let clock: &'static Hands = leak(Hands::default());
    let mut broker = Box::new(SilentBroker::new(clock, NoLane, NoNotify));
    let policy = margin(16).with_categories().with_energy(Microjoules::from_joules(9));
    let agent = broker.agent(policy).unwrap();
    let supervisor = broker.supervisor();
    let lamps: [SilentLamp; 3] = [8, 8, 8].map(|draw| {
        let truth: &'static Truth = leak(Truth::default());
        let gate: &'static mut Gate<'static, Lamp, Silent> =
            leak(Gate::new(Lamp::new(truth, drawing(draw)), clock, NoLane));
        broker.register(agent, gate.key()).unwrap()
    });
    let pass = |time: Duration| {
        broker.service();
        clock.advance(time);
        for lamp in &lamps {
            let estimate = Estimate { state: Power::Off, measured_at: clock.now() };
            broker.observe(lamp.gate(), estimate);
        }
        broker.service();
    };
    let limited = |lamp: usize| lamps[lamp].limited(Function::energy(Microjoules::from_joules(3)));

    let everything = || {
        pass(TICK);
        let low = broker.request(Priority::LEAST, &limited(0)).unwrap();
        broker.service();
        low.invoke(Switch::On).unwrap();
        low.renew().unwrap();
        let refused = broker.request(Priority::LEAST, &(limited(1), limited(2), limited(0)));
        assert!(refused.is_err());
        let unlimited = |lamp: usize| lamps[lamp].limited(Validity::always());
        let set = broker.request(Priority::SCIENCE, &(unlimited(1), unlimited(2))).unwrap();
        assert!(low.invoke(Switch::On).is_err() && low.try_invoke(Switch::On).is_err());
        pass(TICK);
        set.0.invoke(Switch::On).unwrap();
        assert!(set.0.invoke(Switch::Fault).is_err());
        pass(TICK);
        broker.reset_gate(&supervisor, lamps[1].gate()).unwrap();
        pass(TICK);
        broker.bar(&supervisor, set.0.id()).unwrap().quiesce().unwrap();
        pass(TICK);
        broker.reinstate(&supervisor, set.0.id()).unwrap();
        let _ = broker.revoke_all_but_me(&supervisor, &low, Priority::SCIENCE).unwrap().0;
        pass(TICK);
        broker.leave_safe_mode(&supervisor).unwrap();
        pass(TICK);
        drop(set);
        pass(TICK);
        let more = broker.extend(&low, &unlimited(1)).unwrap();
        pass(Duration::from_secs(2));
        assert!(low.check().is_err() && more.check().is_err(), "the lease is over");
        broker.set_supply(&supervisor, agent, bench::watts(15)).unwrap();
        broker.set_supply(&supervisor, agent, bench::watts(16)).unwrap();
    };
    assert_eq!(allocations(everything), 0);
    let seats = broker.books().map(|books| books.free_seats());
    assert_eq!(seats, Some(8), "it did all that");
}
