//! What has become of tickets, told to the manager.

use faregate_agents::Waiting;
use faregate_tickets::id::TicketId;
use faregate_tickets::refusal::Refusal;
use faregate_tickets::standing::Why;

use super::entry::Told;
use super::port::Tickets;
use crate::manager::{Event, Occurrence};

impl Tickets {
    pub(super) fn blocked(&mut self, occurrence: Occurrence, why: String) {
        let Some(entry) = self.entries.get_mut(&occurrence) else { return };
        let told = match &mut entry.told {
            Told::Waits(told) | Told::Taken(told) => told,
            Told::Granted(_) => return,
        };
        if told.as_ref() != Some(&why) {
            *told = Some(why.clone());
            self.told.push(Event::Blocked { occurrence, why });
        }
    }

    /// What has become of an occurrence's tickets since it was looked at last.
    pub(super) fn settle(&mut self, occurrence: Occurrence) {
        let Some(entry) = self.entries.get(&occurrence) else { return };
        let Some(seat) = &entry.seat else { return };
        let checked = seat.ticket.check();
        match (&entry.told, checked) {
            (Told::Granted(then), Ok(())) if seat.ticket.revocations() == *then => {}
            (Told::Granted(_), checked) => self.taken(occurrence, checked.err()),
            (Told::Waits(_) | Told::Taken(_), Err(Refusal::NotValid(Why::Expired))) => {
                self.ask_again(occurrence);
            }
            (Told::Taken(_), _) if entry.runs => {}
            (Told::Waits(_) | Told::Taken(_), Ok(())) => self.granted(occurrence),
            (Told::Waits(_) | Told::Taken(_), Err(_)) => self.waits(occurrence),
        }
    }

    fn taken(&mut self, occurrence: Occurrence, why: Option<Refusal>) {
        let Some(entry) = self.entries.get_mut(&occurrence) else { return };
        let named = why.map(|why| self.shared.names.taker(why));
        let by = entry.taker.take().or(named).unwrap_or_else(|| "somebody, for a moment".into());
        entry.told = Told::Taken(None);
        self.told.push(Event::Taken { occurrence, by });
        if why == Some(Refusal::NotValid(Why::Expired)) {
            self.ask_again(occurrence);
        }
    }

    /// The place is seen on before anybody is told: from then on it is charged
    /// until the body has stopped, even if the tickets go before it starts.
    fn granted(&mut self, occurrence: Occurrence) {
        let Some(entry) = self.entries.get_mut(&occurrence) else { return };
        let Some(seat) = &entry.seat else { return };
        let Some(place) = self.places.get_mut(seat.place) else { return };
        let revocations = seat.ticket.revocations();
        place.see_on(&self.broker);
        if seat.ticket.check().is_err() {
            return place.see_off(&self.broker);
        }
        seat.authority.taken_by(None);
        entry.told = Told::Granted(revocations);
        entry.taker = None;
        self.told.push(Event::Granted { occurrence });
    }

    /// Tells what a request waits for, where that is not in the manager's own
    /// hands: another task is.
    fn waits(&mut self, occurrence: Occurrence) {
        let Some(entry) = self.entries.get(&occurrence) else { return };
        let Some(seat) = &entry.seat else { return };
        let Some(waiting) = self.broker.agents().waiting_for(seat.ticket.id()) else { return };
        let was_taken = matches!(entry.told, Told::Taken(_));
        let is_ours = match waiting {
            Waiting::HandOver => true,
            Waiting::Gate { by, .. }
            | Waiting::Exclusive { by }
            | Waiting::Categories { by: Some(by), .. } => self.is_a_tasks(by),
            // What its takers have, the manager knows.
            Waiting::Margin { .. } => was_taken,
            _ => false,
        };
        if !is_ours {
            let why = self.shared.names.waiting(waiting, &self.shared.gates);
            self.blocked(occurrence, why);
        }
    }

    fn is_a_tasks(&self, ticket: TicketId) -> bool {
        let seats = self.entries.values().filter_map(|entry| entry.seat.as_ref());
        seats.into_iter().any(|seat| seat.ticket.id() == ticket)
    }

    pub(super) fn see_off(&mut self, occurrence: Occurrence) {
        let seat = self.entries.get(&occurrence).and_then(|entry| entry.seat.as_ref());
        let place = seat.and_then(|seat| self.places.get_mut(seat.place));
        if let Some(place) = place {
            place.see_off(&self.broker);
        }
    }
}
