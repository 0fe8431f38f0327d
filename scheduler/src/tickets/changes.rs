//! What the broker told since somebody looked.

use std::sync::atomic::{AtomicBool, Ordering};

use crossbeam::queue::ArrayQueue;
use faregate_runtime::TicketChange;
use faregate_tickets::id::TicketId;

use super::port::Revoked;

/// How many revocations are remembered between two looks.
const REMEMBERED: usize = 1024;

/// Revocations, in the order in which the broker told of them. A ticket that was
/// revoked and restored between two looks is found here alone: its task must
/// hear of it, because its devices were somebody else's in between.
#[derive(Debug)]
pub(super) struct Changes {
    revoked: ArrayQueue<usize>,
    lost: AtomicBool,
}

impl Changes {
    pub(super) fn new() -> Self {
        Self { revoked: ArrayQueue::new(REMEMBERED), lost: AtomicBool::new(false) }
    }

    /// # Timing
    /// Called by whoever did a step at the broker: no lock, no allocation.
    pub(super) fn tell(&self, ticket: TicketId, change: TicketChange) {
        if change == TicketChange::Revoked && self.revoked.push(ticket.serial).is_err() {
            self.lost.store(true, Ordering::Release);
        }
    }

    pub(super) fn take(&self) -> Revoked {
        let mut revoked =
            Revoked { all: self.lost.swap(false, Ordering::AcqRel), ..Revoked::default() };
        // Bounded: what comes meanwhile is for the next look.
        for _ in 0..REMEMBERED {
            let Some(serial) = self.revoked.pop() else { break };
            revoked.serials.insert(serial);
        }
        revoked
    }
}
