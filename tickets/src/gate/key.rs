//! The key: whoever has it decides about the gate.

use core::fmt;

use crate::clock::{Duration, Instant};
use crate::device::{Device, Profile};
use crate::fault::GateFault;
use crate::platform::Platform;
use crate::ticket::{Issuer, Seat, Ticket};
use crate::validity::RanOut;

use super::Gate;
use super::control::{Admission, Blocked, Control, Safed, Vacated};

/// A gate's one key, which knows what its device is.
///
/// An agent takes it apart: the [`Key`] stays with the agent, the
/// [`Handle`] is what requests name the gate with.
pub struct KeyOf<'g, D: Device, P: Platform> {
    gate: &'g Gate<'g, D, P>,
}

impl<'g, D: Device, P: Platform> KeyOf<'g, D, P> {
    pub(super) fn new(gate: &'g Gate<'_, D, P>) -> Self {
        Self { gate }
    }

    /// The authority over the gate, and the way to name it.
    #[must_use]
    pub fn split(self) -> (Key<'g>, Handle<'g, D, P>) {
        (Key { control: self.gate }, Handle { gate: self.gate })
    }
}

impl<D: Device, P: Platform> fmt::Debug for KeyOf<'_, D, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("KeyOf")
    }
}

/// Names a gate, and what its device is. No authority comes with it.
pub struct Handle<'g, D: Device, P: Platform> {
    gate: &'g Gate<'g, D, P>,
}

impl<D: Device, P: Platform> Clone for Handle<'_, D, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D: Device, P: Platform> Copy for Handle<'_, D, P> {}

impl<D: Device, P: Platform> fmt::Debug for Handle<'_, D, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Handle")
    }
}

/// The authority over one gate: to make tickets, to admit a tenant, to put it
/// out, and to issue the safing command. Cannot be copied.
pub struct Key<'g> {
    control: &'g dyn Control,
}

impl fmt::Debug for Key<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key")
    }
}

impl<'g> Key<'g> {
    /// Makes a ticket of this gate. It is valid once it is the gate's tenant
    /// and its stamps are current.
    ///
    /// Answers `None` if the handle is another gate's.
    pub fn ticket<D: Device, P: Platform, A: Issuer>(
        &self,
        handle: Handle<'g, D, P>,
        seat: Seat<'g>,
        issuer: &'g A,
    ) -> Option<Ticket<'g, D, P, A>> {
        let ours = core::ptr::from_ref(self.control).cast::<()>();
        let theirs = core::ptr::from_ref(handle.gate).cast::<()>();
        core::ptr::eq(ours, theirs).then(|| Ticket::new(handle.gate, seat, issuer))
    }

    /// What is declared of the device.
    #[must_use]
    pub fn profile(&self) -> &'g Profile {
        self.control.profile()
    }

    /// Why the gate is faulted, if it is.
    #[must_use]
    pub fn fault(&self) -> Option<GateFault> {
        self.control.fault()
    }

    /// When a limit of the tenant could run out; see [`Key::ran_out`].
    #[must_use]
    pub fn look_again(&self, now: Instant) -> Option<Instant> {
        self.control.look_again(now)
    }

    /// Puts the tenant out and waits until no command is in progress.
    ///
    /// # Errors
    /// [`Blocked`]: stale, or the command in progress did not come back within
    /// `timeout`, which makes the gate faulted.
    ///
    /// # Timing
    /// At most the command in progress, with priority inheritance where the
    /// gate's strategy has it.
    pub fn vacate(&self, tenure: usize, timeout: Duration) -> Result<Vacated, Blocked> {
        self.control.vacate(tenure, timeout)
    }

    /// Issues the safing command in this tenure, after draining, as its
    /// `attempt`th attempt, counted from 1.
    ///
    /// # Errors
    /// As [`Key::vacate`].
    ///
    /// # Timing
    /// At most the command, check or safing in progress, with priority
    /// inheritance where the gate's strategy has it; then the safing
    /// command itself.
    pub fn safe(&self, tenure: usize, attempt: u8, timeout: Duration) -> Result<Safed, Blocked> {
        self.control.safe(tenure, attempt, timeout)
    }

    /// Makes a ticket the tenant; answers the new tenure.
    ///
    /// # Errors
    /// As [`Key::vacate`].
    ///
    /// # Timing
    /// At most the command, check or safing in progress, with priority
    /// inheritance where the gate's strategy has it.
    pub fn admit(&self, admission: Admission<'_>, timeout: Duration) -> Result<usize, Blocked> {
        self.control.admit(admission, timeout)
    }

    /// The device was freshly seen off: limits on use stand still, and an
    /// interlock lets the other side go.
    ///
    /// # Errors
    /// As [`Key::vacate`].
    ///
    /// # Timing
    /// At most the command, check or safing in progress, with priority
    /// inheritance where the gate's strategy has it.
    pub fn seen_off(&self, tenure: usize, at: Instant, timeout: Duration) -> Result<(), Blocked> {
        self.control.seen_off(tenure, at, timeout)
    }

    /// Whether a limit of the tenant with this serial has run out.
    ///
    /// # Timing
    /// At most the command, check or safing in progress, with priority
    /// inheritance where the gate's strategy has it.
    #[must_use]
    pub fn ran_out(&self, serial: usize, timeout: Duration) -> Option<RanOut> {
        self.control.ran_out(serial, timeout)
    }

    /// Passes through the gate once: what was in progress is over, and all it
    /// did is visible.
    ///
    /// # Errors
    /// As [`Key::vacate`].
    ///
    /// # Timing
    /// At most the command, check or safing in progress, with priority
    /// inheritance where the gate's strategy has it.
    pub fn pass(&self, timeout: Duration) -> Result<(), Blocked> {
        self.control.pass(timeout)
    }

    /// Resets a faulted gate.
    ///
    /// # Timing
    /// One atomic store.
    pub fn reopen(&self) {
        self.control.reopen();
    }
}
