//! What is soaked: something with holders that can be revoked.

use std::error::Error;

use faregate::prelude::Refusal;
use faregate_devices_sim::Dice;

use crate::room::{Order, Room};

/// Why the soak did not come to its end.
pub(crate) type Failure = Box<dyn Error + Send + Sync>;

/// What a step comes to.
pub(crate) type Outcome<T> = Result<T, Failure>;

/// A gate or several, their holders' passes, and the authority to revoke them.
/// The revoker's thread has it, and calls its steps in the order in which they
/// stand here.
pub(crate) trait Subject: Sized {
    /// What a holder has.
    type Pass: Pass;

    /// What its holders command.
    fn orders(&self) -> Orders;

    /// The rooms behind its gates.
    fn rooms(&self) -> &[&'static Room];

    /// The holders' passes, all of them, once.
    fn hand_out(&mut self) -> Vec<Self::Pass>;

    /// Chooses how it will revoke, and whom; answers in which rooms, one bit
    /// each.
    fn aim(&mut self, dice: &mut Dice) -> Outcome<u32>;

    /// Revokes.
    fn revoke(&mut self) -> Outcome<()>;

    /// Waits until no command of what was revoked is in progress.
    fn quiesce(&mut self) -> Outcome<()>;

    /// Chooses who will have this room next.
    fn next(&mut self, room: usize, dice: &mut Dice) -> u8;

    /// Lets them in.
    fn admit(&mut self) -> Outcome<()>;
}

/// What holders command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Orders {
    /// Commands that take some steps, of which some wake the revoker.
    Steps,
    /// Stores, and now and then such a command.
    Stores,
    /// Stores that are composed in some steps before, and may wake the revoker.
    ComposedStores,
}

/// What a holder has.
pub(crate) trait Pass: Send {
    /// The holder's number in orders.
    fn holder(&self) -> u8;

    /// Where its commands are carried out.
    fn room(&self) -> &'static Room;

    /// Gives a command, if it is admitted.
    ///
    /// # Errors
    /// It was not; why, where the subject can say so.
    fn invoke(&self, order: Order) -> Result<(), Option<Refusal>>;
}
