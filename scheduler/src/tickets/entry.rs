//! What the port knows of one occurrence.

use std::sync::Arc;

use faregate_runtime::Ticket;

use super::authority::Authority;
use super::place::Place;
use crate::manager::Needs;

/// An occurrence that holds tickets, waits for them, or waits for a place.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) needs: Needs,
    /// The order of asking.
    pub(super) arrival: u64,
    /// Where it stands at the broker; none: it waits for a place.
    pub(super) seat: Option<Seat>,
    pub(super) told: Told,
    /// Whether its body may run.
    pub(super) runs: bool,
    /// For whom its tickets were asked away.
    pub(super) taker: Option<String>,
}

/// A request at the broker.
#[derive(Debug)]
pub(super) struct Seat {
    /// Which place.
    pub(super) place: usize,
    pub(super) ticket: Ticket<Place>,
    pub(super) authority: Arc<Authority>,
}

/// What the manager was told last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Told {
    /// Nothing yet, or for what it waits.
    Waits(Option<String>),
    /// It may run. How often the ticket had been revoked by then: a different
    /// answer says that it was taken, even if it is back.
    Granted(usize),
    /// And for what it waits since, where that is not another task.
    Taken(Option<String>),
}

impl Entry {
    pub(super) fn new(needs: Needs, arrival: u64) -> Self {
        Self { needs, arrival, seat: None, told: Told::Waits(None), runs: false, taker: None }
    }

    /// The place in line: the smaller goes first.
    pub(super) fn rank(&self) -> (u8, u64) {
        (u8::MAX - self.needs.priority.level(), self.arrival)
    }
}
