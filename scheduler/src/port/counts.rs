//! What happened at the ports: for telemetry.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::port::WhyClosed;

/// How often what happened, since the server's start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounts {
    /// Commands that were done.
    pub done: u64,
    /// Commands that were refused.
    pub refused: u64,
    /// Heartbeats.
    pub heartbeats: u64,
    /// Connections that the other side closed.
    pub closed_by_peer: u64,
    /// Connections that were closed over what came: no message, or one too
    /// long.
    pub closed_over_garbage: u64,
    /// Connections that were closed since their answers were not read.
    pub closed_unread: u64,
    /// Connections that ended with their attempt.
    pub closed_at_end: u64,
}

/// The same, while it is counted. Relaxed all over: the counts say nothing of
/// other memory.
#[derive(Debug, Default)]
pub(super) struct Counting {
    pub(super) done: AtomicU64,
    pub(super) refused: AtomicU64,
    pub(super) heartbeats: AtomicU64,
    closed_by_peer: AtomicU64,
    closed_over_garbage: AtomicU64,
    closed_unread: AtomicU64,
    closed_at_end: AtomicU64,
}

impl Counting {
    pub(super) fn closed(&self, why: WhyClosed) {
        let count = match why {
            WhyClosed::Peer => &self.closed_by_peer,
            WhyClosed::Garbage | WhyClosed::TooLong => &self.closed_over_garbage,
            WhyClosed::Unread => &self.closed_unread,
            WhyClosed::AttemptOver => &self.closed_at_end,
        };
        count.fetch_add(1, Relaxed);
    }

    pub(super) fn so_far(&self) -> PortCounts {
        PortCounts {
            done: self.done.load(Relaxed),
            refused: self.refused.load(Relaxed),
            heartbeats: self.heartbeats.load(Relaxed),
            closed_by_peer: self.closed_by_peer.load(Relaxed),
            closed_over_garbage: self.closed_over_garbage.load(Relaxed),
            closed_unread: self.closed_unread.load(Relaxed),
            closed_at_end: self.closed_at_end.load(Relaxed),
        }
    }
}
