//! Margin Kept and Restoration, through a hand-over that several threads serve.

use std::sync::atomic::{AtomicBool, Ordering};

use faregate_tickets::id::Priority;

use crate::flight::Flight;
use crate::lamp::{Given, Switch};
use crate::model::{explore, explore_to, join, keep, spawn};
use crate::stage::{PATIENCE, Stage};

const SUPPLY: u32 = 10;

#[test]
fn margin_kept() {
    explore_to(2, "margin_kept", 500, || {
        let flight = Flight::new(SUPPLY, [8, 7]);
        let camera = flight.granted(Priority::SCIENCE, 0);
        let issuing = spawn(move || {
            let _ = camera.invoke(Switch::On);
            camera
        });
        let service = spawn(|| {
            flight.observe(0);
            flight.broker.service();
        });
        let emergency = flight.request(Priority::EMERGENCY, 1);
        flight.pass();
        let _ = emergency.invoke(Switch::On);
        join(service);
        let _camera = join(issuing);
        assert!(flight.bus.peak() <= SUPPLY, "Margin Kept: the draw exceeds the supply");
        flight.pass();
        assert_eq!(emergency.invoke(Switch::On), Ok(()), "Bounded Hand-over: it is not valid");
        assert!(flight.bus.peak() <= SUPPLY, "Margin Kept: the draw exceeds the supply");
        assert_eq!(flight.charged(), 7, "Margin Kept: the charge is the emergency's alone");
    });
}

#[test]
fn margin_kept_while_commanded() {
    explore_to(2, "margin_kept_while_commanded", 100, || {
        let flight = Flight::new(SUPPLY, [8, 7]);
        let camera = flight.granted(Priority::SCIENCE, 0);
        let service = spawn(|| {
            flight.observe(0);
            flight.broker.service();
        });
        let _ = camera.invoke(Switch::On);
        let emergency = flight.request(Priority::EMERGENCY, 1);
        flight.broker.service();
        let _ = emergency.invoke(Switch::On);
        join(service);
        assert!(flight.bus.peak() <= SUPPLY, "Margin Kept: the draw exceeds the supply");
    });
}

#[test]
fn only_fresh_estimates_credit() {
    explore_to(2, "only_fresh_estimates_credit", 80, || {
        let flight = Flight::new(SUPPLY, [8, 7]);
        let camera = flight.granted(Priority::SCIENCE, 0);
        flight.bus.deaf[0].store(1, Ordering::Relaxed);
        let sensing = spawn(|| {
            flight.observe(0);
            flight.broker.service();
        });
        let _ = camera.invoke(Switch::On);
        let emergency = flight.request(Priority::EMERGENCY, 1);
        flight.broker.service();
        let _ = emergency.invoke(Switch::On);
        join(sensing);
        let _ = emergency.invoke(Switch::On);
        let peak = flight.bus.peak();
        assert!(peak <= SUPPLY, "Margin Kept: an old estimate was credited");
    });
}

#[test]
fn late_safing() {
    explore("late_safing", 10, || {
        let on: &AtomicBool = keep(AtomicBool::new(false));
        let stage = Stage::new(move |given| on.store(given == Given::On, Ordering::Relaxed));
        let restored = stage.ticket(1);
        stage.admit(0, 0).expect("the gate is free");
        let tenure = stage.key.vacate(1, PATIENCE).expect("no command hangs").tenure;
        let stalled = spawn(move || stage.key.safe(tenure, 1, PATIENCE).is_ok());
        stage.key.safe(tenure, 1, PATIENCE).expect("the first attempt is due");
        stage.admit(1, tenure).expect("the gate is vacant");
        restored.invoke(Switch::On).expect("it is valid");
        join(stalled);
        let on = on.load(Ordering::Relaxed);
        assert!(on, "Restoration: late safing hit the restored holder");
    });
}

#[test]
fn restoration() {
    explore_to(2, "restoration", 300, || {
        let flight = Flight::new(SUPPLY, [8, 7]);
        let monitor = flight.request(Priority::SCIENCE, 0);
        let service = spawn(|| flight.broker.service());
        flight.broker.service();
        let emergency = flight.request(Priority::EMERGENCY, 0);
        flight.broker.service();
        drop(emergency);
        flight.broker.service();
        join(service);
        flight.broker.service();
        let issued = monitor.invoke(Switch::On);
        assert_eq!(issued, Ok(()), "Restoration: the restored ticket refuses");
    });
}
