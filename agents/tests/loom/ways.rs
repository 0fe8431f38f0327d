//! The tenant's own ways: by a fence, and by one store.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use faregate_tickets::lock::{Fenced, LoomLocked, LoomSections, LoomWait, Restartable};
use loom::sync::atomic::{AtomicUsize, Ordering};

use crate::lamp::{Given, Lamp, Switch};
use crate::model::{explore, join, keep, spawn};
use crate::stage::{PATIENCE, Stage, Ticket};

type ByFence = Fenced<LoomLocked, LoomWait>;
type ByStore = Restartable<LoomLocked, LoomSections>;

/// A stage whose holder 0 is the tenant, and has its own way open.
fn opened(
    hardware: impl FnMut(Given) + Send + 'static,
) -> (&'static Stage<ByFence>, Ticket<ByFence>) {
    let stage = Stage::<ByFence>::of(Lamp::new(1, hardware));
    let holder = stage.ticket(0);
    stage.admit(0, 0).expect("the gate is free");
    holder.invoke(Switch::Turn(0)).expect("it is valid");
    (stage, holder)
}

/// The device is told of what it does outside the lock, as in the soak.
#[test]
fn empty_room_by_fence() {
    explore("empty_room_by_fence", 30, || {
        let [begun, ended]: &[AtomicUsize; 2] = keep([(); 2].map(|()| AtomicUsize::new(0)));
        let (stage, holder) = opened(move |given| {
            if given == Given::On {
                begun.store(1, Ordering::Relaxed);
                ended.store(1, Ordering::Relaxed);
            }
        });
        let issuing = spawn(move || holder.invoke(Switch::On).is_ok());
        stage.standings[0].bar(1);
        stage.key.pass(PATIENCE).expect("no command hangs");
        let seen = [begun, ended].map(|word| word.load(Ordering::Relaxed));
        let issued = join(issuing);
        let expected = [usize::from(issued); 2];
        assert_eq!(seen, expected, "Empty Room: a command was in progress, or was not visible");
    });
}

/// The holder comes again and again: who waits sees a later entry, or none.
#[test]
fn quiescence_while_hammered() {
    explore("quiescence_while_hammered", 100, || {
        let issued: &AtomicUsize = keep(AtomicUsize::new(0));
        let (stage, holder) = opened(move |given| {
            if given == Given::On {
                issued.store(issued.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
            }
        });
        let hammering = spawn(move || {
            let first = holder.invoke(Switch::On).is_ok();
            let second = holder.invoke(Switch::On).is_ok();
            usize::from(first) + usize::from(second)
        });
        stage.standings[0].bar(1);
        let tenure = stage.key.vacate(1, PATIENCE).expect("no command hangs").tenure;
        let seen = issued.load(Ordering::Relaxed);
        stage.key.safe(tenure, 1, PATIENCE).expect("no command hangs");
        let admitted = join(hammering);
        assert_eq!(seen, admitted, "Empty Room: a command was in progress, or was not visible");
    });
}

#[test]
fn one_tenant_by_fence() {
    explore("one_tenant_by_fence", 100, || {
        let (stage, first) = opened(|_| ());
        let second = stage.ticket(1);
        let leaving = spawn(move || {
            let _ = first.invoke(Switch::On);
            let _ = first.invoke(Switch::On);
        });
        // A bad policy: it changes the tenant, and revokes nobody.
        let tenure = stage.key.vacate(1, PATIENCE).expect("no command hangs").tenure;
        stage.admit(1, tenure).expect("the gate is vacant");
        // Opens its way, and takes it, while the first one is on its own.
        for _ in 0..2 {
            let issued = second.invoke(Switch::Off);
            assert_eq!(issued, Ok(()), "Open Door: a command of the valid ticket was not issued");
        }
        join(leaving);
    });
}

#[test]
fn quiescence_by_store() {
    explore("quiescence_by_store", 10, || {
        let register: &'static AtomicU32 = keep(AtomicU32::new(0));
        let stage = Stage::<ByStore>::of(Lamp::new(0, |_| ()).with(register));
        let holder = stage.ticket(0);
        stage.admit(0, 0).expect("the gate is free");
        holder.invoke(Switch::Turn(1)).expect("it is valid");
        let storing = spawn(move || {
            let _ = holder.invoke(Switch::Turn(2));
            let _ = holder.invoke(Switch::Turn(3));
        });
        // A bad policy: it changes the tenant, and revokes nobody.
        stage.key.vacate(1, PATIENCE).expect("no command hangs");
        let quiescent = register.load(Relaxed);
        join(storing);
        let last = register.load(Relaxed);
        assert_eq!(last, quiescent, "Closed Door: a store was done after quiescence");
    });
}

#[test]
fn closed_door_by_store() {
    explore("closed_door_by_store", 10, || {
        let register: &'static AtomicU32 = keep(AtomicU32::new(0));
        let told: &AtomicUsize = keep(AtomicUsize::new(0));
        let stage = Stage::<ByStore>::of(Lamp::new(0, |_| ()).with(register));
        let holder = stage.ticket(0);
        stage.admit(0, 0).expect("the gate is free");
        holder.invoke(Switch::Turn(1)).expect("it is valid");
        let storing = spawn(move || {
            let told = told.load(Ordering::Acquire) == 1;
            let stored = holder.invoke(Switch::Turn(2)).is_ok();
            assert!(!(told && stored), "Closed Door: a command was admitted after its revocation");
        });
        stage.standings[0].bar(1);
        told.store(1, Ordering::Release);
        join(storing);
    });
}
