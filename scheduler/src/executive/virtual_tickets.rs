//! Tickets without a broker: what agents without delays would answer.

use std::collections::BTreeMap;

use faregate_agents::Categories;

use crate::executive::TicketPort;
use crate::manager::{Event, Needs, Occurrence};
use crate::time::{Instant, Now};

/// Grants tickets at once, in the order (priority, arrival), as far as
/// categories and gates are free; victims are told at once, and their taker is
/// granted when all of them have stopped.
///
/// Draw is not counted: the manager's own books keep the margins, and a device
/// is off as soon as its task has stopped. Lags of estimates, and the time that
/// it takes to make devices safe, are not modelled.
#[derive(Debug, Default)]
pub struct VirtualTickets {
    requests: BTreeMap<Occurrence, Request>,
    reserved: BTreeMap<String, Vec<String>>,
    arrivals: u64,
    events: Vec<Event>,
}

#[derive(Debug)]
struct Request {
    needs: Needs,
    arrival: u64,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Not granted, and its body, if there is one, stands still.
    Waiting,
    Granted,
    /// Taken; its body has not stopped yet, and what it has is not free.
    Stopping,
}

impl VirtualTickets {
    fn take(&mut self, victim: Occurrence, by: &str) {
        let Some(request) = self.requests.get_mut(&victim) else { return };
        if request.state == State::Granted {
            request.state = State::Stopping;
            self.events.push(Event::Taken { occurrence: victim, by: by.to_owned() });
        }
    }

    /// Grants what can be granted, most important first.
    fn settle(&mut self) {
        let mut used = Used::default();
        for gates in self.reserved.values() {
            used.gates.extend(gates.iter().cloned());
        }
        for request in self.requests.values().filter(|request| request.state != State::Waiting) {
            used.add(&request.needs);
        }
        for occurrence in self.waiting() {
            let Some(request) = self.requests.get_mut(&occurrence) else { continue };
            if used.is_free_for(&request.needs) {
                used.add(&request.needs);
                request.state = State::Granted;
                self.events.push(Event::Granted { occurrence });
            }
        }
    }

    fn waiting(&self) -> Vec<Occurrence> {
        let waiting = self.requests.iter().filter(|(_, request)| request.state == State::Waiting);
        let mut order: Vec<_> = waiting
            .map(|(occurrence, request)| {
                (u8::MAX - request.needs.priority.level(), request.arrival, *occurrence)
            })
            .collect();
        order.sort_unstable();
        order.into_iter().map(|(.., occurrence)| occurrence).collect()
    }
}

/// What is not free.
#[derive(Debug, Default)]
struct Used {
    categories: Option<Categories>,
    gates: Vec<String>,
}

impl Used {
    fn add(&mut self, needs: &Needs) {
        let before = self.categories.unwrap_or(Categories::NONE);
        self.categories = Some(before.union(needs.categories));
        self.gates.extend(needs.gates.iter().cloned());
    }

    fn is_free_for(&self, needs: &Needs) -> bool {
        !self.categories.is_some_and(|used| used.overlaps(needs.categories))
            && !needs.gates.iter().any(|gate| self.gates.contains(gate))
    }
}

impl TicketPort for VirtualTickets {
    fn request(&mut self, occurrence: Occurrence, needs: &Needs, victims: &[Occurrence], _: Now) {
        for victim in victims {
            self.take(*victim, &occurrence.task.to_string());
        }
        let arrival = self.arrivals;
        self.arrivals = self.arrivals.saturating_add(1);
        let request = Request { needs: needs.clone(), arrival, state: State::Waiting };
        self.requests.entry(occurrence).or_insert(request);
    }

    fn stopped(&mut self, occurrence: Occurrence, _: Now) {
        if let Some(request) = self.requests.get_mut(&occurrence)
            && request.state == State::Stopping
        {
            request.state = State::Waiting;
        }
    }

    fn relinquish(&mut self, occurrence: Occurrence, _: Now) {
        self.requests.remove(&occurrence);
    }

    fn reserve(&mut self, mode: &str, gates: &[String], _: Now) {
        let uses = |request: &Request| request.needs.gates.iter().any(|gate| gates.contains(gate));
        let users = self.requests.iter().filter(|(_, request)| uses(request));
        let users: Vec<_> = users.map(|(occurrence, _)| *occurrence).collect();
        for victim in users {
            self.take(victim, &format!("mode {mode}"));
        }
        self.reserved.insert(mode.to_owned(), gates.to_vec());
    }

    fn unreserve(&mut self, mode: &str, _: Now) {
        self.reserved.remove(mode);
    }

    fn poll(&mut self, _: Now, events: &mut Vec<Event>) {
        self.settle();
        events.append(&mut self.events);
    }

    /// Nothing happens by itself: each change comes with an action, and after
    /// each decision the ports are looked at again.
    fn next_due(&self) -> Option<Instant> {
        None
    }
}
