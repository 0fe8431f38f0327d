//! Safe mode, and who survives it.

use faregate_tickets::id::Priority;

use crate::flight::Flight;
use crate::model::{explore, join, spawn};
use crate::stage::Stage;

#[test]
fn safe_mode_against_grant() {
    explore("safe_mode_against_grant", 50, || {
        let flight = Flight::new(10, [8, 2]);
        let ticket = flight.request(Priority::SCIENCE, 0);
        let revoking = spawn(|| {
            let floor = Priority::EMERGENCY;
            let revoked = flight.broker.enter_safe_mode(&flight.supervisor, floor);
            revoked.expect("the supervisor is ours").without_waiting();
        });
        flight.broker.service();
        join(revoking);
        assert!(ticket.check().is_err(), "Closed Door: a ticket below the floor is valid");
        flight.pass();
        assert!(ticket.check().is_err(), "Closed Door: a service made it valid below the floor");
        flight.broker.leave_safe_mode(&flight.supervisor).expect("the supervisor is ours");
        flight.broker.service();
        assert_eq!(ticket.check(), Ok(()), "Restoration: safe mode was left");
    });
}

#[test]
fn late_epoch() {
    explore("late_epoch", 5, || {
        let stage = Stage::new(|_| ());
        let ticket = stage.ticket(0);
        let revoking = spawn(|| stage.broker.enter_safe_mode(Priority::EMERGENCY));
        let seen = stage.broker.read();
        if seen.admits(Priority::SCIENCE) {
            stage.admit_at(0, 0, seen.epoch).expect("the gate is free");
        }
        join(revoking);
        assert!(ticket.check().is_err(), "Late Epoch Invariant: valid below the floor");
    });
}

#[test]
fn revoke_all_but_me() {
    explore("revoke_all_but_me", 100, || {
        let flight = Flight::new(10, [8, 2]);
        let me = flight.granted(Priority::SCIENCE, 0);
        let other = flight.granted(Priority::SCIENCE, 1);
        let service = spawn(|| flight.broker.service());
        let (exempt, revoked) = flight
            .broker
            .revoke_all_but_me(&flight.supervisor, &me, Priority::EMERGENCY)
            .expect("the supervisor is ours");
        revoked.without_waiting();
        assert!(exempt, "Closed Door: nobody else revoked it");
        assert_eq!(me.check(), Ok(()), "Closed Door: the exempt ticket was revoked");
        assert!(other.check().is_err(), "Closed Door: the other ticket is still valid");
        join(service);
        flight.pass();
        assert_eq!(me.check(), Ok(()), "Closed Door: a service revoked the exempt ticket");
        assert!(other.check().is_err(), "Closed Door: a service restored the other ticket");
    });
}

#[test]
fn nobody_is_resurrected() {
    explore("nobody_is_resurrected", 50, || {
        let flight = Flight::new(10, [8, 2]);
        let me = flight.granted(Priority::SCIENCE, 0);
        let floor = Priority::EMERGENCY;
        let revoking = spawn(move || {
            let revoked = flight.broker.enter_safe_mode(&flight.supervisor, floor);
            revoked.expect("the supervisor is ours").without_waiting();
        });
        let both = flight.broker.revoke_all_but_me(&flight.supervisor, &me, floor);
        both.expect("the supervisor is ours").1.without_waiting();
        join(revoking);
        assert!(me.check().is_err(), "Closed Door: revoke_all_but_me resurrected its ticket");
        flight.pass();
        assert!(me.check().is_err(), "Closed Door: a service resurrected its ticket");
    });
}
