//! How the broker is asked.

use std::collections::BTreeSet;
use std::sync::Arc;

use faregate_agents::{Capacity, RequestRefused, Waiting};
use faregate_tickets::id::Priority;
use faregate_tickets::validity::{Function, Validity};

use super::authority::Authority;
use super::entry::{Entry, Seat, Told};
use super::place::PlaceState;
use super::port::Tickets;
use super::{MOST_GATES, SLOTS};
use crate::manager::{Event, Needs, Occurrence};

impl Tickets {
    pub(super) fn ask_first(&mut self, occurrence: Occurrence, needs: &Needs) {
        let arrival = self.arrivals;
        self.arrivals = self.arrivals.saturating_add(1);
        self.entries.insert(occurrence, Entry::new(needs.clone(), arrival));
        self.seat(occurrence);
    }

    /// Asks the broker for an occurrence that has no place yet, if there is one.
    pub(super) fn seat(&mut self, occurrence: Occurrence) {
        let Some(needs) = self.entries.get(&occurrence).map(|entry| entry.needs.clone()) else {
            return;
        };
        let Some(place) = self.free_place(&needs) else {
            return self.blocked(occurrence, format!("all {SLOTS} places for tasks are taken"));
        };
        match self.ask(occurrence, &needs, place) {
            Ok(seat) => {
                if let Some(book) = self.places.get_mut(place) {
                    book.state = PlaceState::Taken;
                }
                if let Some(entry) = self.entries.get_mut(&occurrence) {
                    entry.seat = Some(seat);
                }
            }
            Err(Unasked::Full(why)) => self.blocked(occurrence, why),
            Err(Unasked::Never(why)) => {
                self.entries.remove(&occurrence);
                self.told.push(Event::Refused { occurrence, why });
            }
        }
    }

    fn free_place(&mut self, needs: &Needs) -> Option<usize> {
        let broker = &self.broker;
        self.places.iter_mut().zip(0..).find_map(|(place, number)| {
            let is_free = place.state == PlaceState::Free;
            let declared = is_free && place.declare(broker, needs).is_ok();
            declared.then_some(number)
        })
    }

    /// Asks for the place and the gates, all or nothing.
    fn ask(&self, occurrence: Occurrence, needs: &Needs, place: usize) -> Result<Seat, Unasked> {
        let handle = self.places.get(place).map(|place| place.handle);
        let handle = handle.ok_or_else(|| Unasked::Full("there is no such place".to_owned()))?;
        let names: BTreeSet<&String> = needs.gates.iter().collect();
        let mut wants = heapless::Vec::<_, MOST_GATES>::new();
        for name in &names {
            let gate = self.shared.gates.get(name).ok_or_else(|| unknown(name))?;
            let want = gate.handle.limited(Function::lease(self.lease));
            wants.push(want).map_err(|_| too_many(names.len()))?;
        }
        let priority = Priority::new(needs.priority.level());
        let asked = (handle.limited(Validity::always()), wants);
        let (ticket, tickets) = self.broker.request(priority, &asked)?;
        self.shared.names.call(ticket.id(), occurrence.task.to_string());
        let named = names.into_iter().cloned().zip(tickets);
        let authority = Arc::new(Authority::new(named));
        self.shared.give(occurrence, Arc::clone(&authority));
        Ok(Seat { place, ticket, authority })
    }

    /// Whom the manager has chosen as victims, and the broker has not taken:
    /// they came first, and are as important. They stand behind now.
    pub(super) fn take_victims(&mut self, occurrence: Occurrence, victims: &[Occurrence]) {
        for victim in victims {
            let entry = self.entries.get_mut(victim);
            // Requests come in the order of importance: the first one takes.
            if let Some(entry) = entry.filter(|entry| matches!(entry.told, Told::Granted(_))) {
                entry.taker.get_or_insert_with(|| occurrence.task.to_string());
            }
        }
        // The least important is the last to be named.
        for victim in victims.iter().rev() {
            if !self.waits_for_one_of(occurrence, victims) {
                return;
            }
            if self.holds(*victim) {
                self.ask_again(*victim);
            }
        }
    }

    fn holds(&self, occurrence: Occurrence) -> bool {
        let seat = self.entries.get(&occurrence).and_then(|entry| entry.seat.as_ref());
        let waits = |seat: &Seat| self.broker.agents().waiting_for(seat.ticket.id());
        seat.is_some_and(|seat| matches!(waits(seat), None | Some(Waiting::HandOver)))
    }

    /// Whether the request waits for what one of these has.
    fn waits_for_one_of(&self, occurrence: Occurrence, victims: &[Occurrence]) -> bool {
        let seat_of = |of: &Occurrence| self.entries.get(of).and_then(|entry| entry.seat.as_ref());
        let Some(seat) = seat_of(&occurrence) else { return false };
        let is_victims =
            |ticket| victims.iter().filter_map(seat_of).any(|victim| victim.ticket.id() == ticket);
        match self.broker.agents().waiting_for(seat.ticket.id()) {
            Some(
                Waiting::Gate { by, .. }
                | Waiting::Exclusive { by }
                | Waiting::Categories { by: Some(by), .. },
            ) => is_victims(by),
            Some(Waiting::Margin { .. }) => true,
            _ => false,
        }
    }

    /// Gives the tickets back and asks for the same again, behind everybody who
    /// has asked meanwhile. The body keeps its place.
    pub(super) fn ask_again(&mut self, occurrence: Occurrence) {
        let Some(entry) = self.entries.get_mut(&occurrence) else { return };
        let Some(Seat { place, ticket, authority }) = entry.seat.take() else { return };
        let (needs, taker) = (entry.needs.clone(), entry.taker.clone());
        let attempt = authority.attempt();
        self.shared.end(occurrence);
        drop((ticket, authority));
        match self.ask(occurrence, &needs, place) {
            Ok(seat) => {
                seat.authority.serve(attempt);
                seat.authority.taken_by(taker);
                if let Some(entry) = self.entries.get_mut(&occurrence) {
                    entry.seat = Some(seat);
                }
            }
            Err(Unasked::Full(why) | Unasked::Never(why)) => {
                self.lose_place(occurrence, place, &why)
            }
        }
    }

    /// It stood in line, and cannot any more: it waits for a place like one
    /// that has just come, when its body has stopped.
    fn lose_place(&mut self, occurrence: Occurrence, place: usize, why: &str) {
        let Some(entry) = self.entries.get_mut(&occurrence) else { return };
        if matches!(entry.told, Told::Granted(_)) {
            let by = entry.taker.take().unwrap_or_else(|| why.to_owned());
            entry.told = Told::Taken(None);
            self.told.push(Event::Taken { occurrence, by });
        }
        if entry.runs {
            self.runaways.insert(occurrence, place);
        } else if let Some(book) = self.places.get_mut(place) {
            book.state = PlaceState::Leaving;
        }
    }
}

/// Why the broker was not asked.
enum Unasked {
    /// For lack of room: later.
    Full(String),
    /// It never could be granted.
    Never(String),
}

impl From<RequestRefused> for Unasked {
    fn from(refused: RequestRefused) -> Self {
        match refused {
            RequestRefused::NoCapacity(Capacity::Seats | Capacity::Sets) => {
                Self::Full(refused.to_string())
            }
            other => Self::Never(other.to_string()),
        }
    }
}

fn unknown(gate: &str) -> Unasked {
    Unasked::Never(format!("the mission has no gate `{gate}`"))
}

fn too_many(gates: usize) -> Unasked {
    Unasked::Never(format!("it commands {gates} gates, and a task can command {MOST_GATES}"))
}
