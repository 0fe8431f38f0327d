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
    /// Whom it has taken from, and was not granted since: what it needs is owed
    /// to it, and goes to nobody else; least of all to these, who may share a
    /// draw with it, which is not counted here.
    victims: Vec<Occurrence>,
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
    fn arrives(&mut self) -> u64 {
        let arrival = self.arrivals;
        self.arrivals = self.arrivals.saturating_add(1);
        arrival
    }

    /// Takes what was granted; answers whether it was.
    fn take(&mut self, victim: Occurrence, by: &str) -> bool {
        let granted = self.requests.get_mut(&victim);
        let Some(request) = granted.filter(|request| request.state == State::Granted) else {
            return false;
        };
        request.state = State::Stopping;
        self.events.push(Event::Taken { occurrence: victim, by: by.to_owned() });
        true
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
            let is_victim = self.is_victim(occurrence);
            let Some(request) = self.requests.get_mut(&occurrence) else { continue };
            let is_free = !is_victim && used.is_free_for(&request.needs);
            if is_free || !request.victims.is_empty() {
                used.add(&request.needs);
            }
            if is_free {
                request.state = State::Granted;
                request.victims.clear();
                self.events.push(Event::Granted { occurrence });
            }
        }
    }

    /// Whether who has taken its tickets still waits for others to stop.
    fn is_victim(&self, occurrence: Occurrence) -> bool {
        let waiting = self.requests.values().filter(|request| request.state == State::Waiting);
        waiting.into_iter().any(|taker| taker.victims.contains(&occurrence))
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
    /// A victim of the same priority stands behind its taker from now on: the
    /// schedule's order is finer than the agents'. One that has lost its tickets
    /// already keeps its turn, as it does there.
    fn request(&mut self, occurrence: Occurrence, needs: &Needs, victims: &[Occurrence], _: Now) {
        let arrival = self.arrives();
        let mut taken = Vec::new();
        for victim in victims {
            if !self.take(*victim, &occurrence.task.to_string()) {
                continue;
            }
            taken.push(*victim);
            let later = self.arrives();
            if let Some(victim) = self.requests.get_mut(victim)
                && victim.needs.priority == needs.priority
            {
                victim.arrival = later;
            }
        }
        let state = State::Waiting;
        let fresh = || Request { needs: needs.clone(), arrival, state, victims: Vec::new() };
        let request = self.requests.entry(occurrence).or_insert_with(fresh);
        request.victims.extend(taken);
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
