//! A whole broker: requests, service, estimates, supervision.

use std::convert::Infallible;

use faregate_agents::{Broker, Categories, Handle, Policy, Redeclared};
use faregate_tickets::Gate;
use faregate_tickets::amount::{Microjoules, Milliwatts};
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Declaration, Device, Estimate, Power, Profile};
use faregate_tickets::id::{HolderId, Priority};
use faregate_tickets::notify::NoNotify;
use faregate_tickets::validity::{Function, Validity};

use crate::bench::{Hands, Lamp, Switch, TICK, Truth, drawing, leak, margin, watts};
use crate::meter::Meter;
use crate::{Bounded, Silent};

type SilentBroker = Broker<'static, Silent, NoNotify, 5, 8, 2>;
type SilentLamp = Handle<'static, Lamp, Silent>;

/// A device without commands.
struct Place;

impl Device for Place {
    type Command = Infallible;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        Profile::new()
    }
    fn declare(command: &Infallible) -> Declaration {
        match *command {}
    }
    fn issue(&mut self, command: Infallible) -> Result<(), ()> {
        match command {}
    }
    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }
}

const NOTHING: Redeclared = Redeclared {
    draw: Milliwatts::ZERO,
    categories: Categories::NONE,
    settling: Duration::ZERO,
    estimate_lag: Duration::ZERO,
};

const ENERGY: Microjoules = Microjoules::from_joules(3);

/// From the making of a broker to its last ticket.
pub(crate) fn measure() {
    let mut meter = Meter::default();
    let clock: &'static Hands = leak(Hands::default());
    let mut broker =
        meter.op(&["broker::new"], || SilentBroker::new(clock, Bounded::new(), NoNotify));
    let policy = margin(16).with_categories().with_energy(Microjoules::from_joules(9));
    let agent = meter.op(&["broker::agent"], || broker.agent(policy).unwrap());
    let other = broker.agent(Policy::unlimited()).unwrap();
    let (supervisor, of_agent) = meter
        .op(&["supervise::supervisor", "supervise::supervisor_of"], || {
            (broker.supervisor(), broker.supervisor_of(agent).unwrap())
        });
    let lamps: [SilentLamp; 4] = [8, 8, 8, 0].map(|draw| {
        let truth: &'static Truth = leak(Truth::default());
        let gate: &'static mut Gate<'static, Lamp, Silent> =
            leak(Gate::new(Lamp::new(truth, drawing(draw)), clock, Bounded::new()));
        let agent = if draw == 0 { other } else { agent };
        meter.op(&["broker::register", "broker::register_with_categories"], || {
            broker.register(agent, gate.key()).unwrap()
        })
    });
    let gate: &'static mut Gate<'static, Place, Silent> =
        leak(Gate::new(Place, clock, Bounded::new()));
    let place = broker.register(other, gate.key()).unwrap();
    let broker = &broker;
    clock.advance(TICK);
    broker.observe(place.gate(), Estimate { state: Power::Off, measured_at: clock.now() });

    // Time passes, the sensors measure, and service does what is due.
    let pass = |meter: &mut Meter, time: Duration| {
        meter.op(&["service::service_at"], || broker.service_at([lamps[0].gate()]));
        meter.op(&["service::service"], || broker.service());
        clock.advance(time);
        for lamp in &lamps {
            let estimate = Estimate { state: Power::Off, measured_at: clock.now() };
            meter.op(&["broker::observe", "asks::gate"], || broker.observe(lamp.gate(), estimate));
        }
        meter.op(&[], || broker.service());
    };
    let meter = &mut meter;
    let limited = |lamp: usize| lamps[lamp].limited(Function::energy(ENERGY)).held_by(HolderId(5));
    let unlimited = |lamp: usize| lamps[lamp].limited(Validity::always());

    pass(meter, TICK);
    let low = meter.op(&["asks::request", "asks::limited", "asks::held_by"], || {
        broker.request(Priority::LEAST, &limited(0)).unwrap()
    });
    meter.op(&[], || broker.service());
    let low = meter.op(&[], || {
        low.invoke(Switch::On).unwrap();
        low.renew().unwrap();
        low
    });
    meter.op(&[], || {
        let refused = broker.request(Priority::LEAST, &(limited(1), limited(2), limited(0)));
        assert!(refused.is_err(), "there is no such budget");
    });
    let set =
        meter.op(&[], || broker.request(Priority::SCIENCE, &(unlimited(1), unlimited(2))).unwrap());
    let low = meter.op(&[], || {
        assert!(low.invoke(Switch::On).is_err() && low.try_invoke(Switch::On).is_err());
        low
    });
    let id = low.id();
    meter.op(
        &["broker::waiting_for", "broker::device", "broker::margin", "broker::budgets"],
        || {
            assert!(broker.waiting_for(id).is_some() && broker.device(lamps[0].gate()).is_some());
            assert!(broker.margin(agent).is_some() && broker.budgets(agent).is_some());
        },
    );
    meter.op(
        &["broker::hand_over_bound", "broker::books", "broker::free_seats", "broker::now"],
        || {
            assert!(
                broker.hand_over_bound(lamps[0].gate(), 1).is_some() && broker.books().is_some()
            );
            assert_eq!((broker.free_seats(), broker.now()), (Some(6), Some(clock.now())));
        },
    );
    pass(meter, TICK);
    let set = meter.op(&[], || {
        set.0.invoke(Switch::On).unwrap();
        assert!(set.0.invoke(Switch::Fault).is_err());
        set
    });
    pass(meter, TICK);
    meter.op(&["supervise::reset_gate"], || {
        broker.reset_gate(&supervisor, lamps[1].gate()).unwrap()
    });
    pass(meter, TICK);
    let barred = set.0.id();
    meter.op(&["supervise::bar", "supervise::quiesce"], || {
        broker.bar(&supervisor, barred).unwrap().quiesce().unwrap();
    });
    pass(meter, TICK);
    meter.op(&["supervise::reinstate"], || broker.reinstate(&supervisor, barred).unwrap());
    meter.op(&["supervise::bar_holder", "supervise::without_waiting"], || {
        broker.bar_holder(&supervisor, HolderId(5)).unwrap().without_waiting();
    });
    pass(meter, TICK);
    meter.op(&[], || broker.reinstate(&supervisor, id).unwrap());
    let low = meter.op(&["supervise::revoke_all_but_me"], || {
        let all = broker.revoke_all_but_me(&supervisor, &low, Priority::SCIENCE).unwrap();
        all.1.quiesce().unwrap();
        low
    });
    pass(meter, TICK);
    meter.op(&["supervise::enter_safe_mode", "supervise::leave_safe_mode"], || {
        broker.leave_safe_mode(&supervisor).unwrap();
        broker.enter_safe_mode(&of_agent, Priority::EMERGENCY).unwrap().quiesce().unwrap();
    });
    pass(meter, TICK);
    meter.op(&[], || broker.leave_safe_mode(&of_agent).unwrap());
    pass(meter, TICK);
    meter.op(&[], || drop(set));
    pass(meter, TICK);
    let (low, more) = meter.op(&["asks::extend"], || {
        let more = broker.extend(&low, &unlimited(1)).unwrap();
        (low, more)
    });
    pass(meter, Duration::from_secs(2));
    meter.op(&[], || {
        assert!(low.check().is_err() && more.check().is_err(), "the lease is over");
        drop((low, more));
    });
    meter.op(&["redeclare::redeclare"], || broker.redeclare(&place, &NOTHING).unwrap());
    meter.op(&["supervise::set_supply"], || {
        broker.set_supply(&supervisor, agent, watts(15)).unwrap();
        broker.set_supply(&supervisor, agent, Milliwatts::from_watts(16)).unwrap();
    });
    pass(meter, TICK);
    assert_eq!(broker.free_seats(), Some(8), "it did all that");
    let ours = ["", "/asks", "/redeclare", "/service", "/supervise"];
    meter.assert_complete(
        &ours.map(|file| format!("agents/src/broker{file}.rs")).each_ref().map(String::as_str),
        &[],
    );
}
