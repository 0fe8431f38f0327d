//! A supervisor's revocation against what the agent does at the same time.

use faregate_tickets::id::Priority;

use crate::flight::Flight;
use crate::lamp::Switch;
use crate::model::{explore, join, spawn};

#[test]
fn bar_against_grant() {
    explore("bar_against_grant", 20, || {
        let flight = Flight::new(10, [8, 2]);
        let ticket = flight.request(Priority::SCIENCE, 0);
        let barring = spawn(move || {
            let revoked = flight.broker.bar(&flight.supervisor, ticket.id()).expect("it lives");
            revoked.without_waiting();
            let issued = ticket.invoke(Switch::On).is_ok();
            assert!(!issued, "Closed Door: the barred ticket was admitted");
            ticket
        });
        flight.broker.service();
        let ticket = join(barring);
        assert!(ticket.check().is_err(), "Closed Door: a grant undid a bar");
        flight.pass();
        assert!(ticket.check().is_err(), "Closed Door: a service undid a bar");
        flight.broker.reinstate(&flight.supervisor, ticket.id()).expect("it lives");
        flight.broker.service();
        assert_eq!(ticket.check(), Ok(()), "Restoration: a reinstated ticket is valid");
    });
}

#[test]
fn bar_against_preemption() {
    explore("bar_against_preemption", 100, || {
        let flight = Flight::new(10, [8, 2]);
        let monitor = flight.granted(Priority::SCIENCE, 0);
        let id = monitor.id();
        let barring = spawn(move || {
            flight.broker.bar(&flight.supervisor, id).expect("it lives").without_waiting();
        });
        let emergency = flight.request(Priority::EMERGENCY, 0);
        flight.broker.service();
        drop(emergency);
        flight.broker.service();
        join(barring);
        assert!(monitor.check().is_err(), "Closed Door: a restoration undid a bar");
        flight.pass();
        assert!(monitor.check().is_err(), "Closed Door: a later restoration undid a bar");
    });
}
