//! Agents that know of categories only, grant in order, and speak when they
//! are asked to.

use std::collections::{BTreeMap, BTreeSet};

use faregate_scheduler::manager::{Event, Needs, Occurrence};

#[derive(Debug, Default)]
pub(crate) struct Agents {
    requests: BTreeMap<Occurrence, Request>,
    /// Whose tickets somebody outside keeps from being granted.
    pub(crate) barred: BTreeSet<Occurrence>,
    order: u64,
    /// What was not said yet.
    pub(crate) events: Vec<Event>,
}

#[derive(Debug)]
struct Request {
    needs: Needs,
    order: u64,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waiting,
    Granted,
    /// Taken, and its body not stopped yet.
    Stopping,
}

impl Agents {
    pub(crate) fn request(&mut self, occurrence: Occurrence, needs: Needs, victims: &[Occurrence]) {
        self.order += 1;
        let request = Request { needs, order: self.order, state: State::Waiting };
        let before = self.requests.insert(occurrence, request);
        assert!(before.is_none(), "{occurrence} was asked for twice");
        for victim in victims {
            if !self.take(*victim, &occurrence.task.to_string()) {
                continue;
            }
            // It stands behind its taker from now on.
            self.order += 1;
            let order = self.order;
            if let Some(request) = self.requests.get_mut(victim) {
                request.order = order;
            }
        }
    }

    /// Answers whether there was anything to take.
    fn take(&mut self, victim: Occurrence, by: &str) -> bool {
        let Some(request) = self.requests.get_mut(&victim) else { return false };
        let is_granted = request.state == State::Granted;
        if is_granted {
            request.state = State::Stopping;
            self.events.push(Event::Taken { occurrence: victim, by: by.to_owned() });
        }
        is_granted
    }

    pub(crate) fn stopped(&mut self, occurrence: Occurrence) {
        if let Some(request) = self.requests.get_mut(&occurrence)
            && request.state == State::Stopping
        {
            request.state = State::Waiting;
        }
    }

    pub(crate) fn relinquish(&mut self, occurrence: Occurrence) {
        assert!(self.requests.remove(&occurrence).is_some(), "{occurrence} has nothing");
        self.barred.remove(&occurrence);
        self.events.retain(|event| match event {
            Event::Granted { occurrence: of }
            | Event::Taken { occurrence: of, .. }
            | Event::Blocked { occurrence: of, .. } => *of != occurrence,
            _ => true,
        });
    }

    pub(crate) fn asked(&self) -> Vec<Occurrence> {
        self.requests.keys().copied().collect()
    }

    pub(crate) fn bar(&mut self, occurrence: Occurrence) {
        if self.barred.insert(occurrence) {
            self.take(occurrence, "somebody outside");
            let why = "somebody outside".to_owned();
            self.events.push(Event::Blocked { occurrence, why });
        }
    }

    pub(crate) fn unbar(&mut self) {
        self.barred.clear();
    }

    /// Grants what can be granted, most important first, and takes what more
    /// important ones want from less important ones.
    pub(crate) fn settle(&mut self) {
        // What was taken for somebody is not given to somebody else.
        let mut owed = 0;
        for (importance, occurrence) in self.waiting() {
            let wanted = self.requests[&occurrence].needs.categories;
            let others = self.requests.iter().filter(|(other, request)| {
                **other != occurrence
                    && request.state != State::Waiting
                    && request.needs.categories.overlaps(wanted)
            });
            let in_the_way: Vec<_> =
                others.map(|(other, request)| (request.importance(), *other)).collect();
            if wanted.mask() & owed != 0 {
                continue;
            }
            if in_the_way.is_empty() {
                self.requests.get_mut(&occurrence).unwrap().state = State::Granted;
                self.events.push(Event::Granted { occurrence });
            } else if in_the_way.iter().all(|(other, _)| *other > importance) {
                for (_, other) in in_the_way {
                    self.take(other, &occurrence.task.to_string());
                }
                owed |= wanted.mask();
            }
        }
    }

    fn waiting(&self) -> Vec<((u8, u64), Occurrence)> {
        let waiting = self.requests.iter().filter(|(occurrence, request)| {
            request.state == State::Waiting && !self.barred.contains(occurrence)
        });
        let mut waiting: Vec<_> =
            waiting.map(|(occurrence, request)| (request.importance(), *occurrence)).collect();
        waiting.sort_unstable();
        waiting
    }
}

impl Request {
    /// Less is more important.
    fn importance(&self) -> (u8, u64) {
        (u8::MAX - self.needs.priority.level(), self.order)
    }
}
