//! The recorder port: what happened, for the flight recorder.

use crate::clock::Instant;

/// One lane of the flight recorder. Each gate and each broker writes its own,
/// under its own lock, so a lane has one writer at a time.
///
/// # Timing
/// Runs inside the critical section: put the record into a bounded queue, and
/// when that is full count the loss instead of waiting.
pub trait Lane: Send {
    /// Keeps the record, or counts that it could not be kept.
    fn record(&mut self, record: Record);
}

/// A lane that keeps nothing.
#[derive(Debug, Default)]
pub struct NoLane;

impl Lane for NoLane {
    fn record(&mut self, _: Record) {}
}

/// What happened, where, to whom, when.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Record {
    /// When, by the clock of the gate or broker that writes.
    pub at: Instant,
    /// The ticket concerned; 0 where none is.
    pub ticket: usize,
    /// What happened.
    pub event: RecordedEvent,
}

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RecordedEvent {
    /// A command was issued.
    Issued {
        /// The command's number.
        code: u16,
    },
}
