//! Devices without commands, declared anew.

use core::convert::Infallible;

use faregate_tickets::device::Device;
use faregate_tickets::notify::Notify;
use faregate_tickets::platform::Platform;

use crate::books::Redeclared;
use crate::refusal::NotRedeclared;

use super::{Broker, Handle};

impl<'g, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Broker<'g, P, N, G, T, S>
{
    /// Declares a device anew: its draw, categories and times are these from
    /// now on. For devices that stand for something else each time, as the
    /// places in which tasks run do.
    ///
    /// Only a device without commands can be declared anew. What a command may
    /// draw is judged by its gate, which has what was declared when it was made.
    ///
    /// # Errors
    /// [`NotRedeclared`]: a ticket names the gate, or the device has not been
    /// seen off since it was last used. Everything is as it was.
    ///
    /// # Timing
    /// One look at each seat, inside the books' lock.
    pub fn redeclare<D: Device<Command = Infallible>, Q: Platform>(
        &self,
        handle: &Handle<'g, D, Q>,
        declared: &Redeclared,
    ) -> Result<(), NotRedeclared> {
        let gate = self.known(handle).map_err(|_| NotRedeclared::UnknownGate)?;
        let done = self.enter(|ledger| ledger.books.redeclare(gate, declared));
        done.unwrap_or(Err(NotRedeclared::Unavailable))
    }
}
