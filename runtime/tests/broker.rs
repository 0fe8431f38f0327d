//! The broker with real threads: waiting, restoration, death, panics.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::thread;

use faregate_agents::{Policy, RequestRefused, Waiting};
use faregate_runtime::broker::WAITERS;
use faregate_runtime::{Broker, Handle, NotValid, StillHeld};
use faregate_tickets::Device;
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::device::{Declaration, Effect, Estimate, Power, Profile};
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::{InvokeError, Refusal};
use faregate_tickets::validity::Function;

const SOON: Duration = Duration::from_millis(20);
const LONG: Duration = Duration::from_secs(20);

/// A lamp that says whether it is on, and panics when told to.
struct Lamp(Arc<AtomicBool>);

#[derive(Clone, Copy)]
enum Switch {
    On,
    Off,
    Panic,
}

impl Device for Lamp {
    type Command = Switch;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        let mut profile = Profile::new().drawing(Milliwatts::from_watts(8));
        profile.longest_command = Duration::from_secs(1);
        profile
    }

    fn declare(command: &Switch) -> Declaration {
        let effect = match command {
            Switch::On => Effect::on(Milliwatts::from_watts(8)),
            Switch::Off => Effect::Off,
            Switch::Panic => Effect::Unchanged,
        };
        Declaration { code: *command as u16, wcet: Duration::from_secs(1), effect }
    }

    fn issue(&mut self, command: Switch) -> Result<(), ()> {
        match command {
            Switch::Panic => std::panic::resume_unwind(Box::new("scripted")),
            Switch::On | Switch::Off => {
                self.0.store(matches!(command, Switch::On), Ordering::SeqCst);
            }
        }
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        self.issue(Switch::Off)
    }
}

struct Bench {
    broker: Broker,
    lamps: [Handle<Lamp>; 2],
    truths: [Arc<AtomicBool>; 2],
    sensing: Arc<AtomicBool>,
}

/// Two lamps on a supply for one, and a thread of sensors.
fn bench() -> Bench {
    let truths = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
    let mut builder = Broker::builder().expect("the host has wake-ups");
    let agent = builder.agent(Policy::power_margin(Milliwatts::from_watts(10))).expect("room");
    let lamps = [0, 1].map(|lamp: usize| {
        builder.gate(agent, "lamp", Lamp(Arc::clone(&truths[lamp]))).expect("room")
    });
    let broker = builder.start().expect("the host has threads");
    let sensing = Arc::new(AtomicBool::new(true));
    thread::spawn({
        let (broker, truths, sensing) = (broker.clone(), truths.clone(), Arc::clone(&sensing));
        move || {
            while sensing.load(Ordering::SeqCst) {
                for (lamp, truth) in lamps.iter().zip(&truths) {
                    let measured_at = broker.clock().now();
                    let on = truth.load(Ordering::SeqCst);
                    let state = if on { Power::On } else { Power::Off };
                    broker.observe(lamp.gate(), Estimate { state, measured_at });
                }
                thread::park_timeout(core::time::Duration::from_millis(1));
            }
        }
    });
    Bench { broker, lamps, truths, sensing }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.sensing.store(false, Ordering::SeqCst);
    }
}

#[test]
fn the_emergency_waits_for_the_hand_over_and_the_monitor_for_its_return() {
    let bench = bench();
    let Bench { broker, lamps, truths, .. } = &bench;
    let monitor = broker.request(Priority::SCIENCE, &lamps[0]).unwrap();
    broker.wait(&monitor, LONG).unwrap();
    monitor.invoke(Switch::On).unwrap();

    let emergency = broker.request(Priority::EMERGENCY, &lamps[1]).unwrap();
    broker.wait(&emergency, LONG).unwrap();
    assert!(!truths[0].load(Ordering::SeqCst), "the victim was made safe before");
    assert!(monitor.invoke(Switch::On).is_err());
    emergency.invoke(Switch::On).unwrap();

    let waiting = thread::scope(|scope| {
        let waiting = scope.spawn(move || broker.wait(&monitor, LONG).map(|()| monitor));
        drop(emergency);
        waiting.join().unwrap()
    });
    waiting.unwrap().invoke(Switch::On).unwrap();
}

#[test]
fn a_wait_in_vain_says_what_for() {
    let bench = bench();
    let Bench { broker, lamps, .. } = &bench;
    let first = broker.request(Priority::EMERGENCY, &lamps[0]).unwrap();
    broker.wait(&first, LONG).unwrap();
    let second = broker.request(Priority::SCIENCE, &lamps[1]).unwrap();
    let short_by = Milliwatts::from_watts(6);
    let reason = Some(Waiting::Margin { short_by });
    assert_eq!(broker.wait(&second, SOON), Err(NotValid::TimedOut(reason)));
}

#[test]
fn a_ticket_whose_lease_ended_is_not_waited_for() {
    let bench = bench();
    let Bench { broker, lamps, truths, .. } = &bench;
    let want = lamps[0].limited(Function::lease(SOON));
    let ticket = broker.request(Priority::SCIENCE, &want).unwrap();
    broker.wait(&ticket, LONG).unwrap();
    ticket.invoke(Switch::On).unwrap();
    while ticket.check().is_ok() {
        thread::yield_now();
    }
    assert_eq!(broker.wait(&ticket, LONG), Err(NotValid::Expired));
    while truths[0].load(Ordering::SeqCst) {
        thread::yield_now();
    }
}

#[test]
fn a_holder_that_panics_gives_its_ticket_back() {
    let bench = bench();
    let Bench { broker, lamps, .. } = &bench;
    let ticket = broker.request(Priority::EMERGENCY, &lamps[0]).unwrap();
    broker.wait(&ticket, LONG).unwrap();
    let holder = thread::spawn(move || {
        let _mine = ticket;
        std::panic::resume_unwind(Box::new("scripted"));
    });
    let heir = broker.request(Priority::SCIENCE, &lamps[1]).unwrap();
    broker.wait(&heir, LONG).unwrap();
    assert!(holder.join().is_err());
}

#[test]
fn a_holder_that_panics_leaves_no_device_on() {
    let bench = bench();
    let Bench { broker, lamps, truths, .. } = &bench;
    let ticket = broker.request(Priority::EMERGENCY, &lamps[0]).unwrap();
    broker.wait(&ticket, LONG).unwrap();
    ticket.invoke(Switch::On).unwrap();
    let holder = thread::spawn(move || {
        let _mine = ticket;
        std::panic::resume_unwind(Box::new("scripted"));
    });
    assert!(holder.join().is_err());
    // Nobody needs what it draws: it goes off because its holder died.
    while truths[0].load(Ordering::SeqCst) {
        thread::yield_now();
    }
}

#[test]
fn a_driver_that_panics_is_contained_and_closes_its_gate() {
    let bench = bench();
    let Bench { broker, lamps, .. } = &bench;
    let ticket = broker.request(Priority::SCIENCE, &lamps[0]).unwrap();
    broker.wait(&ticket, LONG).unwrap();
    assert_eq!(ticket.invoke(Switch::Panic), Err(InvokeError::Panicked));
    let faulted = Refusal::Faulted(GateFault::Panicked);
    assert_eq!(ticket.invoke(Switch::On), Err(InvokeError::Refused(faulted)));
}

#[test]
fn tickets_go_to_and_fro_under_load_and_none_is_refused_while_valid() {
    let bench = bench();
    let Bench { broker, lamps, .. } = &bench;
    let grants = AtomicU32::new(0);
    thread::scope(|scope| {
        for (number, lamp) in (0_u8..).zip([0_usize, 1, 0, 1]) {
            let (grants, lamp) = (&grants, &lamps[lamp]);
            scope.spawn(move || {
                for round in 0..25_u8 {
                    let priority = Priority::new(round.wrapping_mul(37).wrapping_add(number));
                    let ticket = broker.request(priority, lamp).expect("there is room");
                    broker.wait(&ticket, LONG).expect("everybody gives back in time");
                    // It may have been pre-empted since: then it says so.
                    let _ = ticket.invoke(Switch::On);
                    grants.fetch_add(1, Ordering::SeqCst);
                }
            });
        }
    });
    assert_eq!(grants.load(Ordering::SeqCst), 100);
}

/// It is moved a few times while it is put together, on whatever stack there is.
#[test]
fn tickets_are_served_when_nobody_has_the_broker_any_more() {
    let on = Arc::new(AtomicBool::new(false));
    let ticket = {
        let mut builder = Broker::builder().expect("the host has wake-ups");
        let agent = builder.agent(Policy::exclusive()).expect("room");
        let lamp = builder.gate(agent, "lamp", Lamp(Arc::clone(&on))).expect("room");
        let broker = builder.start().expect("the host has threads");
        let ticket = broker.request(Priority::SCIENCE, &lamp.limited(Function::lease(SOON)));
        let ticket = ticket.expect("it fits");
        broker.wait(&ticket, LONG).expect("nobody else wants it");
        ticket
    };
    ticket.invoke(Switch::On).unwrap();
    // Its lease ends, and the service is still there to see it.
    while on.load(Ordering::SeqCst) {
        thread::yield_now();
    }
}

#[test]
fn a_broker_is_closed_when_its_tickets_are_gone() {
    let bench = bench();
    let ticket = bench.broker.request(Priority::SCIENCE, &bench.lamps[0]).unwrap();
    assert_eq!(bench.broker.close(), Err(StillHeld { tickets: 1 }));
    drop(ticket);
    assert_eq!(bench.broker.close(), Ok(()));
    assert_eq!(bench.broker.close(), Ok(()), "and stays closed");
    let late = bench.broker.request(Priority::SCIENCE, &bench.lamps[0]);
    assert_eq!(late.err(), Some(RequestRefused::Unavailable));
}

#[test]
fn the_ticket_of_another_broker_is_not_waited_for() {
    let (here, there) = (bench(), bench());
    let ticket = there.broker.request(Priority::SCIENCE, &there.lamps[0]).unwrap();
    assert_eq!(here.broker.wait(&ticket, LONG), Err(NotValid::OtherBroker));
}

#[test]
fn less_important_threads_that_wait_keep_no_rescuer_from_its_ticket() {
    let bench = bench();
    let Bench { broker, lamps, .. } = &bench;
    let first = broker.request(Priority::ENGINEERING, &lamps[0]).unwrap();
    broker.wait(&first, LONG).unwrap();
    let waiting = AtomicUsize::new(0);
    thread::scope(|scope| {
        for _ in 0..WAITERS + 4 {
            scope.spawn(|| {
                let ticket = broker.request(Priority::LEAST, &lamps[0]).expect("there are seats");
                waiting.fetch_add(1, Ordering::SeqCst);
                let waited = broker.wait(&ticket, Duration::from_millis(300));
                assert!(matches!(waited, Err(NotValid::TimedOut(_))), "{waited:?}");
            });
        }
        while waiting.load(Ordering::SeqCst) < WAITERS + 4 {
            thread::yield_now();
        }
        let rescuer = broker.request(Priority::EMERGENCY, &lamps[1]).expect("there are seats");
        assert_eq!(broker.wait(&rescuer, LONG), Ok(()));
    });
}
