//! The shell around the books: what the broker does, in steps that a history
//! can hold back, repeat and reorder.

use std::sync::atomic::Ordering::Relaxed;

use faregate_agents::{Actions, DeviceState, Done, Event, Noted, Work};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::gate::{Admission, Blocked};
use faregate_tickets::id::GateId;
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::{Standing, Why};

use super::lamp::with_hung;
use super::world::{GATES, SEATS, World};

/// More steps than any hand-over of so few gates needs.
const MOST_STEPS: usize = 16 * GATES + 16;

impl World<'_> {
    pub(crate) fn feed(&mut self, event: Event) {
        let stuck_before = self.states();
        let mut actions = Actions::default();
        self.books.steps([Event::Tick(self.now()), event], &mut actions);
        self.note_vacated(&stuck_before);
        self.carry_out(&actions);
    }

    fn states(&self) -> Vec<DeviceState> {
        self.gate_ids().map(|gate| self.books.device_report(gate).unwrap().state).collect()
    }

    /// Whoever used a device may have freed it.
    fn note_vacated(&mut self, before: &[DeviceState]) {
        for (gate, (before, after)) in before.iter().zip(self.states()).enumerate() {
            let quiescent =
                matches!(after, DeviceState::Off | DeviceState::Orphaned | DeviceState::Confirming);
            if quiescent && *before != after {
                self.stuck[gate] = false;
            }
        }
    }

    pub(crate) fn carry_out(&mut self, actions: &Actions<GATES>) {
        for noted in &actions.noted {
            match *noted {
                Noted::SeenOff(gate) => self.stuck[usize::from(gate.0)] = false,
                Noted::Stuck(gate) => self.stuck[usize::from(gate.0)] = true,
                Noted::Faulted(..) => {}
            }
        }
        self.check_reasons(actions);
        for (ticket, why) in &actions.revoked {
            self.standing(ticket.seat).revoke(*why);
        }
        for (ticket, why) in &actions.explained {
            let standing = self.standing(ticket.seat);
            standing.explain_now(standing.epoch_seen(), *why);
        }
        for ticket in &actions.ended {
            self.standing(ticket.seat).end();
            self.grants.remove(&ticket.serial);
        }
        let Actions { revoked, explained, ended, granted, noted } = actions;
        self.changes += revoked.len() + explained.len() + ended.len() + granted.len() + noted.len();
        self.follow_rests();
        self.check_charges();
        self.check_granted();
    }

    fn check_reasons(&self, actions: &Actions<GATES>) {
        for (ticket, why) in &actions.revoked {
            let Why::Preempted { by, priority } = why else { continue };
            let Some(taker) = self.grants.get(&by.serial) else { continue };
            let Some(victim) = self.grants.get(&ticket.serial) else { continue };
            assert_eq!(taker.priority, priority.level(), "the taker's priority is true");
            let rank = |it: &super::world::Granted<'_>| (u8::MAX - it.priority, it.arrival);
            assert!(rank(taker) < rank(victim), "{ticket} was taken by a less important {by}");
        }
    }

    /// Who ceases to rest is behind those who came meanwhile.
    fn follow_rests(&mut self) {
        let noticed = self.is_noticed();
        let tenants: Vec<_> = self
            .gate_ids()
            .filter_map(|gate| self.books.device_report(gate).unwrap().tenant)
            .collect();
        for grant in self.grants.values_mut() {
            let waiting = self.books.waiting_for(grant.id);
            let rests = waiting == Some(faregate_agents::Waiting::Resting);
            if grant.resting && !rests && !grant.barred {
                self.arrivals += 1;
                grant.arrival = self.arrivals;
            }
            grant.resting = rests;
            // Until the epoch is noticed, who is pre-empted may come back.
            grant.exempt &= tenants.contains(&grant.id) || !noticed;
        }
    }

    pub(crate) fn standing(&self, seat: u16) -> &Standing {
        &self.ground.standings[usize::from(seat)]
    }

    /// Takes in what can be seen.
    pub(crate) fn look(&mut self) {
        self.look_for_bars();
        let noticed = self.noticed_event();
        self.feed(noticed);
        let mut faults = [None; 64];
        for (fault, key) in faults.iter_mut().zip(&self.keys) {
            *fault = key.fault();
        }
        for (seen, fault) in self.faults.iter_mut().zip(&faults) {
            *seen = fault.is_some();
        }
        self.feed(Event::Faults(faults));
    }

    fn look_for_bars(&mut self) {
        for seat in self.ground.broker.take_bars().seats(u16::try_from(SEATS).unwrap()) {
            let epoch = self.standing(seat).epoch_seen();
            let (serial, counted) = self.books.counted(seat).unwrap();
            if epoch == counted {
                continue;
            }
            let stale =
                self.standing(seat).barred_serial() != serial && epoch == counted.wrapping_add(1);
            if stale || serial == 0 {
                self.feed(Event::HitByStaleBar { seat, epoch });
            } else {
                if let Some(grant) = self.grants.get_mut(&serial) {
                    (grant.barred, grant.resting) = (true, false);
                }
                self.feed(Event::Barred { seat, epoch });
            }
        }
    }

    fn noticed_event(&mut self) -> Event {
        let broker = self.ground.broker.read();
        let agents =
            std::array::from_fn(|n| self.ground.scopes.get(n).map(Scope::read).unwrap_or_default());
        let mut survivors = 0;
        for gate in self.gate_ids() {
            let tenant = self.books.device_report(gate).unwrap().tenant;
            let survives = |id: faregate_tickets::id::TicketId| {
                self.standing(id.seat).survives(id.serial, broker.epoch)
            };
            if tenant.is_some_and(survives) {
                survivors |= 1 << gate.0;
            }
        }
        self.noticed = self.scopes();
        Event::Noticed { broker, agents, survivors }
    }

    /// Does one piece of work, however late.
    pub(crate) fn perform(&self, work: &Work) -> Done {
        let gate = work.gate();
        let number = usize::from(gate.0);
        let key = &self.keys[number];
        let hung = self.ground.truths[number].hung.load(Relaxed);
        let (tenure, done) = with_hung(hung, || match *work {
            Work::Vacate { tenure, timeout, .. } => {
                let vacated = key.vacate(tenure, timeout);
                (tenure, vacated.map(|vacated| Done::Vacated { gate, ended: tenure, vacated }))
            }
            Work::Safe { tenure, attempt, timeout, .. } => {
                let safed = key.safe(tenure, attempt, timeout);
                (tenure, safed.map(|safed| Done::Safed { gate, tenure, attempt, safed }))
            }
            Work::SeenOff { tenure, at, timeout, .. } => {
                let told = key.seen_off(tenure, at, timeout);
                (tenure, told.map(|()| Done::SeenOff { gate, at }))
            }
            Work::Admit { tenure, ticket, validity, agent, stamp, timeout, .. } => {
                let stamp = stamp.map(|stamp| (self.standing(ticket.seat), stamp));
                let serial = ticket.serial;
                let admission = Admission { serial, tenure, agent, validity, stamp };
                let admitted = key.admit(admission, timeout);
                (
                    tenure,
                    admitted.map(|next| Done::Admitted {
                        gate,
                        after: tenure,
                        tenure: next,
                        ticket,
                    }),
                )
            }
        });
        done.unwrap_or_else(|blocked| Done::Blocked { gate, tenure, blocked })
    }

    pub(crate) fn report(&mut self, done: Done) {
        if let Done::Blocked { gate, blocked: Blocked::Hung, .. } = done {
            let state = self.books.device_report(gate).unwrap().state;
            if state == DeviceState::Orphaned {
                self.stuck[usize::from(gate.0)] = true;
            }
        }
        self.feed(Event::Done(done));
    }

    /// All that is due now; how many steps it took.
    pub(crate) fn service(&mut self) -> usize {
        self.look();
        for steps in 0..MOST_STEPS {
            if let Ok(work) = self.books.work() {
                let done = self.perform(&work);
                self.report(done);
            } else if !self.look_at_limits() {
                return steps;
            }
            self.look();
        }
        panic!("service does not come to an end: {:?}", self.books.work());
    }

    /// Whether a limit has run out.
    pub(crate) fn look_at_limits(&mut self) -> bool {
        let now = self.now();
        for gate in self.gate_ids() {
            let number = usize::from(gate.0);
            let hung = self.ground.truths[number].hung.load(Relaxed);
            let Some(tenant) = self.books.device_report(gate).unwrap().tenant else { continue };
            if self.keys[number].look_again(now).is_none_or(|at| at > now) {
                continue;
            }
            let serial = tenant.serial;
            let ran_out = with_hung(hung, || self.keys[number].ran_out(serial, Duration::ZERO));
            if let Some(ran_out) = ran_out {
                self.feed(Event::RanOut { gate, serial, ends_ticket: ran_out.ends_ticket });
                return true;
            }
        }
        false
    }

    pub(crate) fn measure(&self, gate: GateId) -> Estimate {
        let state = self.ground.truths[usize::from(gate.0)].shows(self.now());
        Estimate { state, measured_at: self.now() }
    }

    pub(crate) fn observe(&mut self, gate: GateId, estimate: Estimate) {
        let number = usize::from(gate.0);
        let report = self.books.device_report(gate).unwrap();
        let state = report.state;
        let granted = state == DeviceState::Granted;
        let newer = report.seen.is_none_or(|seen| seen.measured_at < estimate.measured_at);
        self.unbidden_seen = state == DeviceState::Off && estimate.state == Power::On;
        self.feed(Event::Observed(gate, estimate));
        // Seen off in the hands of its holder: it is not stuck.
        if granted && newer && estimate.state == Power::Off {
            self.stuck[number] = false;
        }
    }
}
