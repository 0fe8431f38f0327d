//! **No Allocation**, on a host: once the broker has started, neither a holder
//! nor a waiting requester nor a supervisor nor the service thread calls the
//! allocator, neither to get memory nor to give it back.
//!
//! Each public operation is measured on a fresh thread. What is not measured is
//! for before or after the flight: putting a broker together, closing it, and
//! asking the host for real-time rights.
#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

#[path = "no_allocation/bench.rs"]
mod bench;
#[path = "no_allocation/lamp.rs"]
mod lamp;
#[path = "../../agents/tests/no_allocation/meter.rs"]
mod meter;
#[path = "no_allocation/sys.rs"]
mod sys;

use std::sync::atomic::Ordering::SeqCst;
use std::thread;

use bench::{Bench, alone, calls_of_threads, threads_named};
use faregate_runtime::NotValid;
use faregate_runtime::broker::{TICKETS, WAITERS};
use faregate_runtime::host::{HostFenced, HostRestartable, HostStrategy, Supported};
use faregate_runtime::wake::{Wakeup, Woken};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration};
use faregate_tickets::id::{HolderId, Priority};
use faregate_tickets::validity::Function;
use lamp::Switch;
use meter::{Meter, counted};

#[global_allocator]
static ALLOCATOR: sys::Counting = sys::Counting;

const SOON: Duration = Duration::from_millis(5);
const LONG: Duration = Duration::from_secs(20);

#[test]
fn a_flight_allocates_nothing_behind_the_hosts_lock() {
    fly::<HostStrategy>();
}

#[test]
fn a_flight_allocates_nothing_behind_a_fence() {
    fly::<HostFenced>();
}

#[test]
fn a_flight_allocates_nothing_with_restartable_stores() {
    fly::<HostRestartable>();
}

fn fly<S: Supported>() {
    let _alone = alone();
    let bench = Bench::<S>::new();
    let mut meter = Meter::default();
    // Their own first steps, before the flight, may allocate.
    thread::park_timeout(core::time::Duration::from_millis(50));
    let before = calls_of_threads();
    requests(&bench, &mut meter);
    commands(&bench, &mut meter);
    supervision(&bench, &mut meter);
    limits(&bench, &mut meter);
    assert_eq!(calls_of_threads(), before, "the service thread or the recorder");
    meter.assert_complete(&["runtime/src/broker.rs"], &NOT_IN_FLIGHT);
    assert_eq!(bench.broker.close(), Ok(()));
}

const NOT_IN_FLIGHT: [&str; 15] = [
    "broker::new",
    "broker::categories",
    "broker::watching",
    "broker::interlocked",
    "broker::agent",
    "broker::gate",
    "broker::gate_with",
    "broker::gate_behind",
    "broker::supervisor",
    "broker::supervisor_of",
    "broker::real_time",
    "broker::watch",
    "broker::start",
    "broker::builder",
    "broker::close",
];

/// Requests, waiting in vain and with success, restoration, giving back.
fn requests<S: Supported>(bench: &Bench<S>, meter: &mut Meter) {
    let Bench { broker, lamps, .. } = bench;
    let science = meter.op(&["broker::request"], || {
        broker.request(Priority::SCIENCE, &lamps[0].limited(Function::lease(LONG))).unwrap()
    });
    let science = meter.op(&["broker::wait"], || {
        broker.wait(&science, LONG).unwrap();
        science.invoke(Switch::On).unwrap();
        science
    });
    let vain = meter.op(&[], || {
        let vain = broker.request(Priority::LEAST, &lamps[1]).unwrap();
        assert!(matches!(broker.wait(&vain, SOON), Err(NotValid::TimedOut(Some(_)))));
        vain
    });
    // The lamp of the first one is made safe; its holder waits for its return.
    let emergency = meter.op(&[], || broker.request(Priority::EMERGENCY, &lamps[1]).unwrap());
    bench.measure_until(meter, || broker.agents().waiting_for(emergency.id()).is_none());
    let emergency = meter.op(&[], || {
        broker.wait(&emergency, LONG).unwrap();
        emergency.invoke(Switch::On).unwrap();
        emergency.invoke(Switch::Off).unwrap();
        emergency
    });
    let refused = meter.op(&[], || {
        assert!(science.invoke(Switch::On).is_err());
        science
    });
    meter.op(&[], || emergency.relinquish());
    bench.measure_until(meter, || broker.agents().waiting_for(refused.id()).is_none());
    meter.op(&[], || {
        broker.wait(&refused, LONG).unwrap();
        drop((refused, vain));
    });
    bench.measure_until(meter, || broker.agents().free_seats() == Some(TICKETS));
}

/// Commands, alone and against another thread that is inside the gate.
fn commands<S: Supported>(bench: &Bench<S>, meter: &mut Meter) {
    let Bench { broker, lamps, truths, .. } = bench;
    let ticket = broker.request(Priority::SCIENCE, &lamps[0]).unwrap();
    broker.wait(&ticket, LONG).unwrap();
    // More records than the lane holds: what is lost is only counted.
    let ticket = meter.op(&[], || {
        for level in 0..10_000 {
            ticket.invoke(Switch::Dim(level)).unwrap();
            ticket.try_invoke(Switch::Off).unwrap();
        }
        ticket.renew().unwrap();
        ticket.check().unwrap();
        ticket
    });
    let id = ticket.id();
    thread::scope(|scope| {
        let inside = scope.spawn(|| {
            let (ticket, calls) = counted(|| {
                ticket.invoke(Switch::Hold).unwrap();
                ticket
            });
            assert_eq!(calls, 0, "whoever is waited for");
            drop(ticket);
        });
        while !truths[0].held.load(SeqCst) {
            thread::yield_now();
        }
        // Who waits at the gate is a fresh thread, and sleeps in the kernel.
        scope.spawn(|| {
            thread::park_timeout(core::time::Duration::from_millis(20));
            truths[0].held.store(false, SeqCst);
        });
        meter.op(&[], || {
            broker.agents().bar(&bench.supervisor, id).unwrap().quiesce().unwrap();
        });
        inside.join().unwrap();
    });
    let ticket = broker.request(Priority::SCIENCE, &lamps[0]).unwrap();
    broker.wait(&ticket, LONG).unwrap();
    let ticket = meter.op(&[], || {
        ticket.invoke(Switch::Fault).unwrap_err();
        ticket.invoke(Switch::On).unwrap_err();
        ticket
    });
    let gate = lamps[0].gate();
    meter.op(&["broker::agents"], || broker.agents().reset_gate(&bench.supervisor, gate).unwrap());
    meter.op(&[], || drop(ticket));
    bench.measure_until(meter, || broker.agents().free_seats() == Some(TICKETS));
}

/// What supervisors do, and sets and extensions on the way.
fn supervision<S: Supported>(bench: &Bench<S>, meter: &mut Meter) {
    let (broker, lamps) = (&bench.broker, &bench.lamps);
    let (agents, supervisor) = (broker.agents(), &bench.supervisor);
    let supply = Milliwatts::from_watts(16);
    meter.op(&[], || agents.set_supply(supervisor, bench.agent, supply).unwrap());
    let want = |lamp: usize| lamps[lamp].limited(Function::lease(LONG)).held_by(HolderId(4));
    let (one, two) =
        meter.op(&[], || broker.request(Priority::SCIENCE, &(want(0), want(1))).unwrap());
    let one = meter.op(&[], || {
        broker.wait(&one, LONG).unwrap();
        one
    });
    let id = one.id();
    meter.op(&[], || agents.bar_holder(supervisor, HolderId(4)).unwrap().quiesce().unwrap());
    meter.op(&[], || agents.reinstate(supervisor, id).unwrap());
    meter.op(&[], || {
        agents.enter_safe_mode(&bench.of_agent, Priority::EMERGENCY).unwrap().quiesce().unwrap();
    });
    meter.op(&[], || agents.leave_safe_mode(&bench.of_agent).unwrap());
    bench.measure_until(meter, || agents.waiting_for(id).is_none());
    let one = meter.op(&[], || {
        broker.wait(&one, LONG).unwrap();
        let (exempt, revoked) =
            agents.revoke_all_but_me(supervisor, &one, Priority::EMERGENCY).unwrap();
        revoked.quiesce().unwrap();
        assert!(exempt);
        one
    });
    meter.op(&[], || agents.leave_safe_mode(supervisor).unwrap());
    meter.op(&[], || drop((one, two)));
    bench.measure_until(meter, || agents.free_seats() == Some(TICKETS));
    let first = meter.op(&[], || broker.request(Priority::SCIENCE, &want(0)).unwrap());
    let both = meter.op(&["broker::extend"], || {
        let second = broker.extend(&first, &want(1)).unwrap();
        (first, second)
    });
    meter.op(&["broker::real_time_report"], || broker.real_time_report().is_none());
    meter.op(&[], || drop(both));
    bench.measure_until(meter, || agents.free_seats() == Some(TICKETS));
}

/// What the service does by itself; waiters without a bell; bells themselves.
fn limits<S: Supported>(bench: &Bench<S>, meter: &mut Meter) {
    let Bench { broker, lamps, truths, .. } = bench;
    let brief = lamps[0].limited(Function::lease(SOON));
    let ticket = meter.op(&[], || {
        let ticket = broker.request(Priority::SCIENCE, &brief).unwrap();
        broker.wait(&ticket, LONG).unwrap();
        ticket.invoke(Switch::On).unwrap();
        ticket
    });
    bench.measure_until(meter, || !truths[0].on.load(SeqCst));
    meter.op(&[], || {
        assert_eq!(broker.wait(&ticket, LONG), Err(NotValid::Expired));
        drop(ticket);
    });
    bench.measure_until(meter, || broker.agents().free_seats() == Some(TICKETS));
    let bell = Wakeup::new().unwrap();
    meter.op(&[], || {
        bell.notify();
        assert_eq!(bell.wait_until(None).unwrap(), Woken::Notified);
        let now = broker.clock().now();
        assert_eq!(bell.wait_until(Some(now.after(SOON))).unwrap(), Woken::Deadline);
    });
    crowd(bench);
}

/// More threads wait than there are bells for.
fn crowd<S: Supported>(bench: &Bench<S>) {
    let Bench { broker, lamps, .. } = bench;
    let owner = broker.request(Priority::EMERGENCY, &lamps[0]).unwrap();
    broker.wait(&owner, LONG).unwrap();
    thread::scope(|scope| {
        for _ in 0..WAITERS + 2 {
            scope.spawn(|| {
                let waited = counted(|| {
                    let ticket = broker.request(Priority::LEAST, &lamps[0]).unwrap();
                    broker.wait(&ticket, Duration::from_millis(100))
                });
                assert!(matches!(waited, (Err(NotValid::TimedOut(_)), 0)), "{waited:?}");
            });
        }
    });
    drop(owner);
}

#[test]
fn a_thread_is_counted_by_its_name() {
    let _alone = alone();
    let (tell, told) = std::sync::mpsc::channel();
    let busy = thread::Builder::new().name("faregate-test".into()).spawn(move || {
        drop(Box::new(1));
        tell.send(()).unwrap();
        thread::park();
        drop(Box::new(1));
    });
    let busy = busy.unwrap();
    told.recv().unwrap();
    let tid = threads_named("faregate-test")[0];
    let before = sys::calls_of(tid);
    busy.thread().unpark();
    busy.join().unwrap();
    assert!(before >= 2 && sys::calls_of(tid) >= before + 2);
}
