//! Source Death: holders that die in a command, as victims, and while they are
//! being served.

use faregate_tickets::fault::GateFault;
use faregate_tickets::id::Priority;
use faregate_tickets::refusal::InvokeError;

use crate::flight::Flight;
use crate::lamp::Switch;
use crate::model::{explore_to, join, spawn};

const SUPPLY: u32 = 10;

#[test]
fn death_in_a_command() {
    explore_to(2, "death_in_a_command", 300, || {
        let flight = Flight::new(SUPPLY, [8, 7]);
        let camera = flight.granted(Priority::SCIENCE, 0);
        let dying = spawn(move || {
            // The ticket goes with the thread.
            camera.invoke(Switch::Die) == Err(InvokeError::Panicked)
        });
        let emergency = flight.request(Priority::EMERGENCY, 1);
        flight.pass();
        let _ = emergency.invoke(Switch::On);
        let died = join(dying);
        flight.pass();
        assert_eq!(emergency.invoke(Switch::On), Ok(()), "Source Death: the rescuer was hit");
        assert!(flight.bus.peak() <= SUPPLY, "Margin Kept: the draw exceeds the supply");
        assert_eq!(flight.charged(), 7, "Source Death: the dead one's charge stays");
        let report = flight.broker.device(flight.lamps[0].gate()).expect("it is registered");
        let fault = died.then_some(GateFault::Panicked);
        assert_eq!(report.fault, fault, "Source Death: the gate is faulted");
        assert_eq!(report.tenant, None, "Source Death: the dead one keeps its authority");
    });
}

#[test]
fn death_of_a_victim() {
    explore_to(2, "death_of_a_victim", 40, || {
        let flight = Flight::new(SUPPLY, [8, 7]);
        let camera = flight.granted(Priority::SCIENCE, 0);
        camera.invoke(Switch::On).expect("it is valid");
        let emergency = flight.request(Priority::EMERGENCY, 1);
        let dying = spawn(move || drop(camera));
        flight.pass();
        let _ = emergency.invoke(Switch::On);
        join(dying);
        flight.pass();
        assert_eq!(emergency.invoke(Switch::On), Ok(()), "Source Death: the rescuer was hit");
        assert!(flight.bus.peak() <= SUPPLY, "Margin Kept: the draw exceeds the supply");
        drop(emergency);
        flight.pass();
        let seats = flight.broker.books().map(|books| books.free_seats());
        assert_eq!(seats, Some(4), "Source Death: the dead one keeps its seat");
    });
}

#[test]
fn death_while_served() {
    explore_to(2, "death_while_served", 300, || {
        let flight = Flight::new(SUPPLY, [8, 7]);
        let monitor = flight.granted(Priority::SCIENCE, 0);
        let emergency = flight.request(Priority::EMERGENCY, 1);
        let service = spawn(|| flight.pass());
        let dying = spawn(move || drop(emergency));
        flight.broker.service();
        join(dying);
        join(service);
        // Its device is not wanted by anybody; the monitor's is.
        flight.pass();
        flight.pass();
        assert_eq!(flight.charged(), 8, "Source Death: the dead one's charge stays");
        assert_eq!(monitor.check(), Ok(()), "Source Death: nobody was restored");
    });
}
