//! Who waits for which ticket, and the bells that wake them.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fmt, io};

use crossbeam::queue::ArrayQueue;
use crossbeam::utils::CachePadded;
use faregate_tickets::clock::Instant;
use faregate_tickets::id::TicketId;
use faregate_tickets::notify::Notify;

use crate::broker::WAITERS;
use crate::wake::Wakeup;

/// How often a thread looks that has no bell.
const LOOK_AGAIN: std::time::Duration = std::time::Duration::from_millis(1);

/// A bell for the service thread, and one for each thread that waits.
///
/// A thread that waits takes a bell and marks it with its ticket's seat before
/// it looks at the ticket. A bell rung too often only makes its thread look
/// once more; none is rung too seldom, because who makes a ticket valid does so
/// under the broker's lock, which the waiter's own service has passed through
/// since it marked its bell.
pub struct Waiters {
    service: Wakeup,
    bells: Box<[CachePadded<Bell>]>,
    free: ArrayQueue<usize>,
    watchers: OnceLock<Vec<Watcher>>,
}

/// What a watcher is told of a ticket.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TicketChange {
    /// It became valid, or has ended.
    GrantedOrEnded,
    /// It was revoked, and waits or is barred. It may be valid again by now.
    Revoked,
}

/// Is told of every ticket that changed.
pub(crate) type Watcher = Box<dyn Fn(TicketId, TicketChange) + Send + Sync>;

#[derive(Debug)]
struct Bell {
    wakeup: Wakeup,
    /// The seat waited for, counted from 1; 0 for none.
    seat: AtomicUsize,
}

impl Waiters {
    pub(crate) fn new() -> io::Result<Self> {
        let bell =
            |_| Ok(CachePadded::new(Bell { wakeup: Wakeup::new()?, seat: AtomicUsize::new(0) }));
        let bells: io::Result<Vec<_>> = (0..WAITERS).map(bell).collect();
        let free = ArrayQueue::new(WAITERS);
        for bell in 0..WAITERS {
            // There is room for each.
            let _ = free.push(bell);
        }
        let watchers = OnceLock::new();
        Ok(Self { service: Wakeup::new()?, bells: bells?.into(), free, watchers })
    }

    /// Who watches, from now on. Set once, before the service starts.
    pub(crate) fn told_by(&self, watchers: Vec<Watcher>) {
        let _ = self.watchers.set(watchers);
    }

    fn tell_watchers(&self, ticket: TicketId, change: TicketChange) {
        for watcher in self.watchers.get().into_iter().flatten() {
            watcher(ticket, change);
        }
    }

    /// A bell for this ticket, unless all are taken.
    pub(crate) fn register(&self, ticket: TicketId) -> Option<Waiter<'_>> {
        let number = self.free.pop()?;
        let bell = &self.bells[number];
        // Release, with the Acquire in `ticket_changed`: who sees the mark may
        // ring. That it is seen in time is ordered by the broker's lock.
        bell.seat.store(usize::from(ticket.seat) + 1, Ordering::Release);
        Some(Waiter { waiters: self, number, bell })
    }

    /// Waits for the bell, or until the deadline; without a bell a little while.
    pub(crate) fn wait(&self, waiter: Option<&Waiter<'_>>, deadline: Instant) {
        match waiter {
            Some(waiter) => waiter.wait_until(deadline),
            None => std::thread::park_timeout(LOOK_AGAIN),
        }
    }

    pub(crate) fn wake_service(&self) {
        self.service.notify();
    }

    pub(crate) fn wait_for_service(&self, due: Option<Instant>) {
        if self.service.wait_until(due).is_err() {
            // The kernel cannot wait: better busy than blind.
            std::thread::yield_now();
        }
    }
}

impl Notify for Waiters {
    fn ticket_changed(&self, ticket: TicketId) {
        let seat = usize::from(ticket.seat) + 1;
        for bell in &self.bells {
            if bell.seat.load(Ordering::Acquire) == seat {
                bell.wakeup.notify();
            }
        }
        self.tell_watchers(ticket, TicketChange::GrantedOrEnded);
    }

    fn ticket_revoked(&self, ticket: TicketId) {
        self.tell_watchers(ticket, TicketChange::Revoked);
    }

    fn service_due(&self) {
        self.service.notify();
    }
}

impl fmt::Debug for Waiters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Waiters").field("bells", &self.bells).finish_non_exhaustive()
    }
}

/// A thread that waits for a ticket.
pub(crate) struct Waiter<'a> {
    waiters: &'a Waiters,
    number: usize,
    bell: &'a Bell,
}

impl Waiter<'_> {
    pub(crate) fn wait_until(&self, deadline: Instant) {
        if self.bell.wakeup.wait_until(Some(deadline)).is_err() {
            std::thread::yield_now();
        }
    }
}

impl Drop for Waiter<'_> {
    fn drop(&mut self) {
        self.bell.seat.store(0, Ordering::Release);
        let _ = self.waiters.free.push(self.number);
    }
}
