//! Open Door, Closed Door, Empty Room, One Tenant: what meets at one gate.

use std::sync::Mutex;

use faregate_tickets::id::Priority;
use loom::sync::atomic::{AtomicUsize, Ordering};

use crate::flight::Flight;
use crate::lamp::{Given, Switch};
use crate::model::{explore, join, keep, spawn};
use crate::stage::{PATIENCE, Stage};

#[test]
fn closed_door() {
    explore("closed_door", 30, || {
        let flight = Flight::new(10, [8, 2]);
        let holder = flight.granted(Priority::SCIENCE, 0);
        let id = holder.id();
        let told: &AtomicUsize = keep(AtomicUsize::new(0));
        let issuing = spawn(move || {
            let _ = holder.invoke(Switch::On);
            let told = told.load(Ordering::Acquire) == 1;
            let late = holder.invoke(Switch::On).is_ok();
            assert!(!(told && late), "Closed Door: a command was admitted after its revocation");
            holder
        });
        let revoked = flight.broker.bar(&flight.supervisor, id).expect("it lives");
        told.store(1, Ordering::Release);
        let _quiescent = revoked.quiesce().expect("no command hangs");
        let on = flight.bus.is_on(0);
        let _holder = join(issuing);
        assert_eq!(flight.bus.is_on(0), on, "Closed Door: a command was issued after quiescence");
    });
}

#[test]
fn empty_room() {
    explore("empty_room", 10, || {
        let [begun, ended]: &[AtomicUsize; 2] = keep([(); 2].map(|()| AtomicUsize::new(0)));
        let stage = Stage::new(move |_| {
            begun.store(1, Ordering::Relaxed);
            ended.store(1, Ordering::Relaxed);
        });
        let holder = stage.ticket(0);
        stage.admit(0, 0).expect("the gate is free");
        let issuing = spawn(move || holder.invoke(Switch::On).is_ok());
        stage.standings[0].bar(1);
        stage.key.pass(PATIENCE).expect("no command hangs");
        let seen = [begun, ended].map(|word| word.load(Ordering::Relaxed));
        let issued = join(issuing);
        let expected = [usize::from(issued); 2];
        assert_eq!(seen, expected, "Empty Room: a command was in progress, or was not visible");
    });
}

#[test]
fn open_door() {
    explore("open_door", 30, || {
        let stage = Stage::new(|_| ());
        let [refused, valid] = [stage.ticket(0), stage.ticket(1)];
        stage.admit(0, 0).expect("the gate is free");
        let hammering = spawn(move || {
            let _ = refused.invoke(Switch::On);
            let _ = refused.invoke(Switch::On);
        });
        stage.standings[0].bar(1);
        let tenure = stage.key.vacate(1, PATIENCE).expect("no command hangs").tenure;
        stage.admit(1, tenure).expect("the gate is vacant");
        let issued = valid.invoke(Switch::On);
        assert_eq!(issued, Ok(()), "Open Door: a command of the valid ticket was not issued");
        join(hammering);
    });
}

#[test]
fn one_tenant() {
    explore("one_tenant", 30, || {
        let log: &Mutex<Vec<Given>> = keep(Mutex::default());
        let stage = Stage::new(move |given| log.lock().expect("whole").push(given));
        let [first, second] = [stage.ticket(0), stage.ticket(1)];
        stage.admit(0, 0).expect("the gate is free");
        let leaving = spawn(move || {
            let _ = first.invoke(Switch::On);
            first
        });
        // A bad policy: it changes the tenant, and revokes nobody.
        let tenure = stage.key.vacate(1, PATIENCE).expect("no command hangs").tenure;
        stage.admit(1, tenure).expect("the gate is vacant");
        second.invoke(Switch::Off).expect("it is valid");
        let first = join(leaving);
        let both = first.check().is_ok() && second.check().is_ok();
        assert!(!both, "One Tenant: two tickets of one gate are valid together");
        let last = log.lock().expect("whole").last().copied();
        assert_eq!(last, Some(Given::Off), "One Tenant: a command came after the next tenant's");
    });
}
