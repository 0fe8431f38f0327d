//! Highest First: requests over several gates, all or nothing, that cross.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::id::Priority;
use faregate_tickets::validity::Validity;

use crate::flight::{Flight, Ticket};
use crate::model::{explore_to, join, spawn};

/// A request for both lamps, named in this order.
fn both(flight: &'static Flight, priority: Priority, order: [usize; 2]) -> (Ticket, Ticket) {
    let [first, second] = order.map(|lamp| flight.lamps[lamp].limited(Validity::always()));
    flight.broker.request(priority, &(first, second)).expect("it fits the supply")
}

fn valid((first, second): &(Ticket, Ticket)) -> [bool; 2] {
    [first.check().is_ok(), second.check().is_ok()]
}

#[test]
fn highest_first() {
    explore_to(2, "highest_first", 60, || {
        let flight = Flight::new(16, [8, 8]);
        let crossing = spawn(|| {
            let science = both(flight, Priority::SCIENCE, [0, 1]);
            flight.broker.service();
            science
        });
        let emergency = both(flight, Priority::EMERGENCY, [1, 0]);
        flight.broker.service();
        let science = join(crossing);
        flight.pass();
        assert_eq!(valid(&emergency), [true; 2], "Highest First: the emergency has not got all");
        assert_eq!(valid(&science), [false; 2], "Highest First: the other one has something");
    });
}

#[test]
fn first_come() {
    explore_to(2, "first_come", 60, || {
        let flight = Flight::new(16, [8, 8]);
        let crossing = spawn(|| {
            let one = both(flight, Priority::SCIENCE, [0, 1]);
            flight.broker.service();
            one
        });
        let other = both(flight, Priority::SCIENCE, [1, 0]);
        flight.broker.service();
        let one = join(crossing);
        flight.pass();
        let (first, last) =
            if one.0.id().serial < other.0.id().serial { (one, other) } else { (other, one) };
        assert_eq!(valid(&first), [true; 2], "Highest First: the first that came waits");
        assert_eq!(valid(&last), [false; 2], "Highest First: the last that came has something");
    });
}

#[test]
fn taken_in_vain() {
    explore_to(2, "taken_in_vain", 200, || {
        let flight = Flight::new(16, [8, 8]);
        let science = flight.granted(Priority::SCIENCE, 0);
        let falling = spawn(|| {
            let ten = Milliwatts::from_watts(10);
            let _ = flight.broker.set_supply(&flight.supervisor, flight.agent, ten);
            flight.broker.service();
        });
        let emergency = both(flight, Priority::EMERGENCY, [0, 1]);
        flight.broker.service();
        join(falling);
        flight.pass();
        flight.pass();
        let kept = science.check();
        assert_eq!(kept, Ok(()), "Highest First: a victim was taken in vain");
        assert_eq!(valid(&emergency), [false; 2], "Margin Kept: the supply fell below it");
    });
}
