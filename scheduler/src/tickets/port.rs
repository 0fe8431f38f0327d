//! The ticket port of the schedule manager, on a broker.

use std::collections::BTreeMap;
use std::sync::Arc;

use faregate_runtime::Broker;
use faregate_tickets::id::GateId;

use super::authority::{Commander, Shared};
use super::entry::{Entry, Seat};
use super::modes::Modes;
use super::place::PlaceBook;
use crate::manager::{Event, Occurrence};
use crate::time::{Duration, Instant};

/// Asks the agents of a broker for tickets, and tells the manager what became
/// of them.
///
/// Each occurrence has a place and the gates that it commands, all or nothing.
/// A place is free for another task when the broker has seen it off, which is
/// when its body stands still: so who takes a task's tickets is granted its own
/// no sooner than the task has stopped.
#[derive(Debug)]
pub struct Tickets {
    pub(super) broker: Broker,
    pub(super) shared: Arc<Shared>,
    pub(super) places: Vec<PlaceBook>,
    pub(super) entries: BTreeMap<Occurrence, Entry>,
    /// Bodies that run on though their tickets were given back, and their
    /// places.
    pub(super) runaways: BTreeMap<Occurrence, usize>,
    pub(super) modes: Modes,
    pub(super) told: Vec<Event>,
    pub(super) arrivals: u64,
    pub(super) lease: Duration,
    pub(super) renewal: Option<Instant>,
    /// A place is not off that is to be. It rings when it is made safe, but the
    /// agents may hear of that later than the manager, whose measurement then
    /// came too early: so it is measured again.
    pub(super) unsettled: bool,
    /// When it was looked at last.
    pub(super) looked: Instant,
}

impl Tickets {
    pub(super) fn new(
        broker: Broker,
        shared: Arc<Shared>,
        mut places: Vec<PlaceBook>,
        lease: Duration,
    ) -> Self {
        for place in &mut places {
            place.free(&broker);
        }
        Self {
            broker,
            shared,
            places,
            entries: BTreeMap::new(),
            runaways: BTreeMap::new(),
            modes: Modes::default(),
            told: Vec::new(),
            arrivals: 0,
            lease,
            renewal: None,
            unsettled: false,
            looked: Instant::START,
        }
    }

    /// What commands devices on the tickets that this port has, from any
    /// thread.
    #[must_use]
    pub fn commander(&self) -> Commander {
        Commander(Arc::clone(&self.shared))
    }

    /// The broker: for estimates of devices, supplies, reports.
    #[must_use]
    pub fn broker(&self) -> &Broker {
        &self.broker
    }

    /// Does what is due of hand-overs and waits for nobody's command: at places,
    /// which have none, and at gates that a request has got and not entered.
    /// Where a device must be vacated or made safe first, the broker's own
    /// thread does it.
    pub(super) fn drive(&self) {
        let places = self.places.iter().map(|place| place.handle.gate());
        let seats = self.entries.values().filter_map(|entry| entry.seat.as_ref());
        let admitting: Vec<GateId> = seats.flat_map(|seat| self.got(seat)).collect();
        self.broker.agents().service_at(places.chain(admitting));
    }

    fn got(&self, seat: &Seat) -> impl Iterator<Item = GateId> {
        let (agents, ticket) = (self.broker.agents(), &seat.ticket);
        let waits = ticket.check().is_err() && seat.authority.has_devices();
        let gates = seat.authority.gates().filter(move |_| waits);
        gates.filter_map(|gate| self.shared.gates.id(gate)).filter(move |gate| {
            agents.device(*gate).and_then(|report| report.tenant) == Some(ticket.id())
        })
    }
}
