//! What gates and holders share without a lock: interlocks, state variables,
//! and the reasons of revocations.

use faregate_tickets::clock::Instant;
use faregate_tickets::id::{Priority, TicketId};
use faregate_tickets::interlock::{Interlock, Side};
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;
use faregate_tickets::telemetry::{Channel, Telemetry};
use faregate_tickets::validity::{Function, Validity};
use loom::sync::atomic::{AtomicUsize, Ordering};

use crate::lamp::{Given, Switch};
use crate::model::{explore, explore_to, join, keep, spawn};
use crate::stage::{PATIENCE, Stage, Ticket};

/// A gate on one side of an interlock, seen off, and its valid ticket.
fn side(
    interlock: &'static Interlock,
    side: Side,
    hardware: impl FnMut(Given) + Send + 'static,
) -> (&'static Stage, Ticket) {
    let stage = Stage::interlocked(interlock.member(side, 0).expect("a free place"), hardware);
    let validity = Validity::from(Function::interlock());
    stage.admit_with(0, 0, validity).expect("the gate is free");
    let told = stage.key.seen_off(1, Instant::FAR_FUTURE, PATIENCE);
    told.expect("no command hangs");
    (stage, stage.ticket(0))
}

#[test]
fn interlock() {
    explore("interlock", 10, || {
        let interlock: &Interlock = keep(Interlock::new());
        let (_, heater) = side(interlock, Side::A, |_| ());
        let (_, valve) = side(interlock, Side::B, |_| ());
        let heating = spawn(move || heater.invoke(Switch::On).is_ok());
        let firing = valve.invoke(Switch::On).is_ok();
        let heating = join(heating);
        assert!(!(heating && firing), "Interlock: both sides are on");
        let alone = valve.invoke(Switch::On).is_ok();
        assert_eq!(alone, !heating, "Interlock: only the other side's being on refuses");
    });
}

#[test]
fn interlock_withdrawn() {
    explore("interlock_withdrawn", 5, || {
        let interlock: &Interlock = keep(Interlock::new());
        let heat: &AtomicUsize = keep(AtomicUsize::new(0));
        let (cooling, heater) = side(interlock, Side::A, move |given| {
            heat.store(usize::from(given == Given::On), Ordering::Relaxed);
        });
        let seen: &AtomicUsize = keep(AtomicUsize::new(0));
        let (_, valve) = side(interlock, Side::B, move |_| {
            seen.store(heat.load(Ordering::Relaxed), Ordering::Relaxed);
        });
        heater.invoke(Switch::On).expect("the other side is off");
        let cooling = spawn(move || {
            heater.invoke(Switch::Off).expect("it is valid");
            // Measured long after: the sensors say off.
            let told = cooling.key.seen_off(1, Instant::FAR_FUTURE, PATIENCE);
            told.expect("no command hangs");
        });
        let _ = valve.invoke(Switch::On);
        join(cooling);
        let heat = seen.load(Ordering::Relaxed);
        assert_eq!(heat, 0, "Interlock: the other side was still on");
        let alone = valve.invoke(Switch::On).is_ok();
        assert!(alone, "Interlock: the other side was seen off");
    });
}

#[test]
fn telemetry() {
    explore("telemetry", 100, || {
        let table: &Telemetry = keep(Telemetry::new());
        // Across a change of the upper half.
        let times = [(1_u64 << 32) - 2, 1 << 32, (1 << 32) + 3];
        let channel = Channel::new(0).expect("there is one");
        table.publish(channel, 0, Instant::from_micros(times[0]));
        // Loom remembers the last load of a word alone, and who publishes loads
        // too: so the reader is the thread that comes second.
        let reading = spawn(move || {
            let now = 2_u64 << 32;
            let reading = table.read(channel, Instant::from_micros(now)).expect("it was measured");
            let said = now - reading.age.as_micros();
            let truth = times[usize::try_from(reading.value).expect("0 to 2")];
            assert!(said <= truth, "Bounded Validity: an old value was read with a new time");
        });
        table.publish(channel, 1, Instant::from_micros(times[1]));
        table.publish(channel, 2, Instant::from_micros(times[2]));
        join(reading);
    });
}

#[test]
fn reasons() {
    explore_to(2, "reasons", 100, || {
        let stage = Stage::new(|_| ());
        let ticket = stage.ticket(0);
        let by = |serial, level| Why::Preempted {
            by: TicketId { seat: 0, serial },
            priority: Priority::new(level),
        };
        let reasons = [by(10, 10), by(11, 11)];
        stage.standings[0].revoke(reasons[0]);
        let revoking = spawn(move || stage.standings[0].revoke(reasons[1]));
        let barring = spawn(move || stage.standings[0].bar(1));
        let said = ticket.check();
        let true_ones = [reasons[0], reasons[1], Why::Barred, Why::Unknown];
        let told = true_ones.map(|why| Err(Refusal::NotValid(why))).contains(&said);
        assert!(told, "Every Refusal Explains Itself: nobody revoked it like that");
        join(revoking);
        join(barring);
    });
}
