//! The holders: they hammer, refused or not.

use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, Ordering};

use faregate::prelude::Refusal;
use faregate_devices_sim::Dice;

use crate::place::Place;
use crate::room::{Order, Stores};
use crate::subject::{Failure, Orders, Outcome, Pass};

/// A thread that holds passes.
pub(crate) struct Hammer {
    pub(crate) place: Place,
    pub(crate) orders: Orders,
    pub(crate) dice: Dice,
    pub(crate) held: Held,
    pub(crate) refused_in_a_row: u32,
}

/// What it saw.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Held {
    pub(crate) admitted: u64,
    pub(crate) refused: u64,
    latest: Option<Refusal>,
}

impl Held {
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            admitted: self.admitted + other.admitted,
            refused: self.refused + other.refused,
            latest: self.latest.or(other.latest),
        }
    }

    pub(crate) fn explain(&self, why: &Failure) -> Failure {
        match self.latest {
            Some(latest) => format!("{why} (a holder was last refused because: {latest})").into(),
            None => format!("{why} (no holder was ever refused)").into(),
        }
    }
}

impl Hammer {
    /// Tries its passes in turn until it is stopped. None begins before all are
    /// set up: the first would keep the others from it, on one processor.
    pub(crate) fn hammer<P: Pass>(
        mut self,
        passes: &[P],
        ready: &Barrier,
        stop: &AtomicBool,
    ) -> Outcome<Held> {
        let set_up = self.place.set_up_holder();
        ready.wait();
        set_up?;
        let mut number = 0_u32;
        // Relaxed: it says nothing about other memory.
        while !stop.load(Ordering::Relaxed) {
            for pass in passes {
                number = number.wrapping_add(1);
                self.try_one(pass, number);
            }
        }
        Ok(self.held)
    }

    fn try_one(&mut self, pass: &impl Pass, number: u32) {
        let order = self.order(pass.holder(), number);
        match Self::give(pass, order) {
            Ok(()) => {
                self.held.admitted += 1;
                self.refused_in_a_row = 0;
                self.place.think(&mut self.dice);
            }
            Err(refusal) => {
                self.held.refused += 1;
                self.held.latest = refusal;
                self.place.after_refusal(self.refused_in_a_row, &mut self.dice);
                self.refused_in_a_row += 1;
            }
        }
    }

    fn give(pass: &impl Pass, order: Order) -> Result<(), Option<Refusal>> {
        let Some(word) = order.word else { return pass.invoke(order) };
        let room = pass.room();
        room.stores.set_trying(order.holder, true);
        let given = pass.invoke(order);
        room.stores.set_trying(order.holder, false);
        if given.is_ok() {
            room.vouch(order.holder, word);
        }
        given
    }

    fn order(&mut self, holder: u8, number: u32) -> Order {
        let dice = &mut self.dice;
        let steps = u16::try_from(dice.below(16)).unwrap_or(0);
        let word = Some(Stores::word(holder, number));
        let bell = self.place.has_bell();
        match self.orders {
            Orders::Stores if dice.below(64) > 0 => Order { holder, steps: 0, ring: false, word },
            Orders::Stores => Order { holder, steps, ring: bell, word: None },
            Orders::ComposedStores => {
                Order { holder, steps, ring: bell && dice.below(8) == 0, word }
            }
            Orders::Steps => Order { holder, steps, ring: bell && dice.below(8) == 0, word: None },
        }
    }
}
