//! **No Allocation**: nothing calls the allocator, neither to get memory nor to
//! give it back. Each public operation is measured on a fresh thread.

mod bench;
#[path = "no_allocation/brokers.rs"]
mod brokers;
#[path = "no_allocation/mechanism.rs"]
mod mechanism;
#[path = "no_allocation/meter.rs"]
mod meter;
#[path = "no_allocation/sys.rs"]
mod sys;

use bench::{Caught, Hands};
use faregate_tickets::Platform;
use faregate_tickets::lock::Locked;
use faregate_tickets::recorder::{Lane, Record};

#[global_allocator]
static ALLOCATOR: sys::Counting = sys::Counting;

/// A recorder lane with room for a few records, in place: the test's own tape
/// allocates.
#[derive(Debug)]
struct Bounded {
    latest: heapless::Deque<Record, 8>,
    lost: usize,
}

impl Bounded {
    fn new() -> Self {
        Self { latest: heapless::Deque::new(), lost: 0 }
    }
}

impl Lane for Bounded {
    fn record(&mut self, record: Record) {
        if self.latest.push_back(record).is_err() {
            self.lost += 1;
        }
    }
}

/// The platform that is measured.
#[derive(Debug)]
struct Silent;

impl Platform for Silent {
    type Strategy = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;
    type Clock = &'static Hands;
    type Lane = Bounded;
    type Containment = Caught;
}

#[test]
fn no_ticket_key_or_validity_function_allocates() {
    mechanism::measure();
}

#[test]
fn nothing_allocates_after_construction() {
    brokers::measure();
}

#[test]
fn the_count_counts() {
    assert_eq!(meter::counted(|| drop(Box::new(1))).1, 2, "it is got and given back");
    assert_eq!(meter::counted(|| Vec::from([1_u8; 9])).1, 1);
    let grown = |mut bytes: Vec<u8>| bytes.extend([1; 99]);
    let bytes = Vec::with_capacity(1);
    assert_eq!(meter::counted(|| grown(bytes)).1, 3, "growing is both, and then it goes");
}

#[test]
#[should_panic(expected = "calls the allocator")]
fn an_operation_that_allocates_is_found() {
    meter::Meter::default().op(&["box::new"], || Box::new(1));
}

#[test]
#[should_panic(expected = "calls the allocator")]
fn a_thread_local_that_allocates_at_its_first_use_is_found() {
    thread_local! { static BOXED: Box<u8> = Box::new(1); }
    assert_eq!(BOXED.with(|boxed| **boxed), 1);
    meter::Meter::default().op(&["local::first"], || BOXED.with(|boxed| **boxed));
}

#[test]
#[should_panic(expected = "not measured: [\"scope::admits\"")]
fn a_public_method_that_is_not_measured_is_found() {
    meter::Meter::default().assert_complete(&["tickets/src/scope.rs"], &[]);
}
