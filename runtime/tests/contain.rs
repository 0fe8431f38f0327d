//! *Source Death*: a driver's panic becomes a value.

use std::panic::panic_any;

use faregate_runtime::contain::Caught;
use faregate_tickets::platform::{Containment, Panicked};

#[test]
fn a_panic_becomes_a_value() {
    assert_eq!(Caught::contain(|| -> u8 { panic!("the driver is broken") }), Err(Panicked));
}

#[test]
fn what_does_not_panic_answers_as_it_would_alone() {
    let mut issued = 0;
    let answer = Caught::contain(|| {
        issued += 1;
        issued
    });
    assert_eq!((answer, issued), (Ok(1), 1));
}

#[test]
fn what_a_panic_leaves_behind_is_dropped() {
    let witness = std::sync::Arc::new(());
    let thrown = witness.clone();
    assert_eq!(Caught::contain(|| -> () { panic_any(thrown) }), Err(Panicked));
    assert_eq!(std::sync::Arc::strong_count(&witness), 1);
}

/// Throws the next of its kind when dropped, as long as there is one.
struct Hydra {
    heads: u8,
}

impl Drop for Hydra {
    #[expect(clippy::panic, reason = "the fault that is to be contained")]
    fn drop(&mut self) {
        if let Some(heads) = self.heads.checked_sub(1) {
            panic_any(Hydra { heads });
        }
    }
}

#[test]
fn a_panic_that_panics_when_dropped_is_contained_too() {
    for heads in 0..3 {
        let contained = Caught::contain(|| -> () { panic_any(Hydra { heads }) });
        assert_eq!(contained, Err(Panicked));
    }
}
