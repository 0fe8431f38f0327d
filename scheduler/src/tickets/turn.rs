//! The port as the executive calls it.

use super::entry::{Entry, Told};
use super::place::{PlaceBook, PlaceState};
use super::port::Tickets;
use crate::executive::TicketPort;
#[cfg(target_os = "linux")]
use crate::executive::Watched;
use crate::manager::{Attempt, Event, Needs, Occurrence};
use crate::time::{Duration, Instant, Now};

/// So often in the time of a lease is it renewed: twice in vain is not too late.
const RENEWALS: u64 = 3;
/// When a place is looked at again that is to be off, and is not yet.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

impl TicketPort for Tickets {
    fn request(&mut self, occurrence: Occurrence, needs: &Needs, victims: &[Occurrence], _: Now) {
        if !self.entries.contains_key(&occurrence) {
            self.ask_first(occurrence, needs);
        }
        self.take_victims(occurrence, victims);
        self.drive();
    }

    fn started(&mut self, attempt: Attempt, _: Now) {
        let Some(entry) = self.entries.get_mut(&attempt.occurrence) else { return };
        entry.runs = true;
        if let Some(seat) = &entry.seat {
            seat.authority.serve(attempt.number);
        }
    }

    fn stopped(&mut self, occurrence: Occurrence, _: Now) {
        if let Some(place) = self.runaways.remove(&occurrence)
            && let Some(book) = self.places.get_mut(place)
        {
            book.state = PlaceState::Leaving;
        }
        // Its place is seen off in the turn that follows.
        if let Some(entry) = self.entries.get_mut(&occurrence) {
            entry.runs = false;
        }
    }

    fn relinquish(&mut self, occurrence: Occurrence, _: Now) {
        let Some(entry) = self.entries.remove(&occurrence) else { return };
        let Entry { seat: Some(seat), runs, .. } = entry else { return };
        seat.authority.serve(0);
        self.shared.end(occurrence);
        if runs {
            self.runaways.insert(occurrence, seat.place);
        } else if let Some(book) = self.places.get_mut(seat.place) {
            book.state = PlaceState::Leaving;
        }
    }

    fn reserve(&mut self, mode: &str, gates: &[String], _: Now) {
        self.modes.enter(mode, gates, &self.broker, &self.shared);
    }

    fn unreserve(&mut self, mode: &str, _: Now) {
        self.modes.leave(mode);
    }

    fn poll(&mut self, now: Now, events: &mut Vec<Event>) {
        self.modes.settle();
        self.free_places();
        self.seat_those_who_wait();
        self.drive_those_who_wait();
        for occurrence in self.in_order() {
            self.settle(occurrence);
        }
        self.renew(now.elapsed);
        events.append(&mut self.told);
    }

    fn next_due(&self) -> Option<Instant> {
        let again = self.unsettled.then_some(self.looked.after(LOOK_AGAIN));
        self.renewal.into_iter().chain(again).min()
    }
}

impl Tickets {
    /// The most important first: what is told in one turn is told in this order.
    fn in_order(&self) -> Vec<Occurrence> {
        let mut order: Vec<_> =
            self.entries.iter().map(|(occurrence, entry)| (entry.rank(), *occurrence)).collect();
        order.sort_unstable();
        order.into_iter().map(|(_, occurrence)| occurrence).collect()
    }

    /// Places whose bodies are over or stand still are seen off, as soon as the
    /// broker has vacated them and made them safe.
    fn free_places(&mut self) {
        let is_leaving = |place: &&mut PlaceBook| place.state == PlaceState::Leaving;
        let stopped = self.stopped_and_charged();
        self.unsettled = false;
        if stopped.is_empty() && !self.places.iter_mut().any(|place| is_leaving(&place)) {
            return;
        }
        self.drive();
        for place in self.places.iter_mut().filter(is_leaving) {
            place.free(&self.broker);
        }
        for occurrence in &stopped {
            self.see_off(*occurrence);
        }
        self.unsettled = self.places.iter_mut().any(|place| is_leaving(&place))
            || stopped.iter().any(|occurrence| self.is_charged(*occurrence));
    }

    fn is_charged(&self, occurrence: Occurrence) -> bool {
        let seat = self.entries.get(&occurrence).and_then(|entry| entry.seat.as_ref());
        let place = seat.and_then(|seat| self.places.get(seat.place));
        place.is_some_and(|place| !place.is_off(&self.broker))
    }

    fn drive_those_who_wait(&self) {
        let waits = |entry: &Entry| entry.seat.is_some() && !matches!(entry.told, Told::Granted(_));
        if self.entries.values().any(waits) {
            self.drive();
        }
    }

    /// Whose body stands still, and whose place may have been made safe only
    /// since.
    fn stopped_and_charged(&self) -> Vec<Occurrence> {
        let stopped = |entry: &Entry| !entry.runs && matches!(entry.told, Told::Taken(_));
        let entries = self.entries.iter().filter(|(_, entry)| stopped(entry));
        entries.map(|(occurrence, _)| *occurrence).collect()
    }

    fn seat_those_who_wait(&mut self) {
        for occurrence in self.in_order() {
            let waits = |entry: &Entry| entry.seat.is_none() && !entry.runs;
            if self.entries.get(&occurrence).is_some_and(waits) {
                self.seat(occurrence);
            }
        }
    }

    fn renew(&mut self, now: Instant) {
        self.looked = now;
        let seats = self.entries.values().filter_map(|entry| entry.seat.as_ref());
        let mut leased = seats.filter(|seat| seat.authority.has_devices()).peekable();
        if leased.peek().is_none() {
            self.renewal = None;
            return;
        }
        if self.renewal.is_some_and(|at| at > now) {
            return;
        }
        leased.for_each(|seat| seat.authority.renew());
        let period = Duration::from_micros(self.lease.as_micros() / RENEWALS);
        self.renewal = Some(now.after(period.max(LOOK_AGAIN)));
    }
}

/// It rings the manager's bell.
#[cfg(target_os = "linux")]
impl Watched for Tickets {}
