//! The notify port: who is to be woken.

use crate::id::TicketId;

/// Wakes those who wait. Called after all locks are released.
///
/// # Timing
/// Called by whoever did the step, a rescuer included: it must not block.
pub trait Notify: Sync {
    /// The ticket became valid, or has ended.
    fn ticket_changed(&self, ticket: TicketId);

    /// The ticket was revoked, and has not ended: it waits, rests or is barred.
    /// Who waits for it need not wake. Who watches what others hold does; a
    /// host without such leaves this as it is.
    ///
    /// That the ticket refuses does not depend on this: it is told afterwards.
    fn ticket_revoked(&self, ticket: TicketId) {
        let _ = ticket;
    }

    /// There is something to do for `service`.
    fn service_due(&self);
}

/// Wakes nobody: for programs that call `service` themselves.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoNotify;

impl Notify for NoNotify {
    fn ticket_changed(&self, _: TicketId) {}

    fn service_due(&self) {}
}

impl<N: Notify + Send + ?Sized> Notify for &N {
    fn ticket_changed(&self, ticket: TicketId) {
        (**self).ticket_changed(ticket);
    }

    fn ticket_revoked(&self, ticket: TicketId) {
        (**self).ticket_revoked(ticket);
    }

    fn service_due(&self) {
        (**self).service_due();
    }
}
