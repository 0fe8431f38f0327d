//! Service: whatever is due, done by whoever calls.

use faregate_tickets::clock::{Clock, Instant};
use faregate_tickets::gate::{Admission, Key};
use faregate_tickets::id::{GateId, Priority};
use faregate_tickets::lock::Exclusion;
use faregate_tickets::notify::Notify;
use faregate_tickets::platform::Platform;
use faregate_tickets::recorder::{Lane, Record, RecordedEvent};
#[cfg(feature = "mutant-lost-bar")]
use faregate_tickets::standing::Stamp;

use crate::books::{Done, Event, Work};
use crate::limits::MAX_GATES;

use super::{Broker, Changed, Ledger};

/// How many are told at once that their tickets changed.
const TOLD: usize = 8;

/// What a look at the books found.
#[expect(clippy::large_enum_variant, reason = "there is no heap to put the large one on")]
enum Found {
    Work(Work),
    /// A limit of this gate's tenant may have run out.
    Limit {
        gate: GateId,
        serial: usize,
    },
    /// More tickets that changed than are told of at once.
    Changed,
    /// Nothing, until then.
    Due(Option<Instant>),
}

impl<'g, P: Platform, N: Notify, const G: usize, const T: usize, const S: usize>
    Broker<'g, P, N, G, T, S>
{
    /// No call does more steps than this: each gate's hand-over several times
    /// over. What is left is due at once.
    const MOST_STEPS: usize = 16 * G + 16;

    /// Does what is due: hand-overs, limits that run out, restoration. Answers
    /// when something may become due by itself; before that, only somebody's
    /// doing makes it due, and [`Notify::service_due`] says so.
    ///
    /// Called by the service thread, and by a waiting requester at its own
    /// priority. Any number of threads may call it together; none holds up
    /// another, because a step that one has begun another may do.
    ///
    /// # Timing
    /// Each step waits at most for the command in progress at one gate; the
    /// number of steps is bounded by the gates. After a bar the seats are looked
    /// at that it can be in: one, or of more seats than a word has bits, each
    /// 32nd or 64th.
    pub fn service(&self) -> Option<Instant> {
        let mut event = None;
        for _ in 0..Self::MOST_STEPS {
            match self.look(event.take()) {
                Found::Work(work) => event = self.perform(&work).map(Event::Done),
                Found::Limit { gate, serial } => event = self.look_at_limit(gate, serial),
                Found::Changed => {}
                Found::Due(due) => return due,
            }
        }
        if let Some(event) = event {
            self.look(Some(event));
        }
        self.notify.service_due();
        self.now()
    }

    /// Does what is due at these gates, and at no others: for who wants a
    /// hand-over done now, and must not wait for a command in progress at a gate
    /// that it does not ask for. What is due elsewhere is left to the service.
    ///
    /// # Timing
    /// As [`Broker::service`], with waits at these gates only.
    pub fn service_at(&self, gates: impl IntoIterator<Item = GateId>) {
        let gates = gates.into_iter().fold(0, |bits, gate| bits | crate::books::bit(gate));
        let find = |ledger: &Ledger<P, G, T, S>, _| {
            ledger.books.work_at(gates).map_or(Found::Due(None), Found::Work)
        };
        let mut event = None;
        for _ in 0..Self::MOST_STEPS {
            match self.look_for(event.take(), &find) {
                Found::Work(work) => event = self.perform(&work).map(Event::Done),
                Found::Limit { .. } | Found::Changed => {}
                Found::Due(_) => return,
            }
        }
        if let Some(event) = event {
            self.look_for(Some(event), &find);
        }
    }

    fn look(&self, event: Option<Event>) -> Found {
        self.look_for(event, &|ledger, now| self.find(ledger, now))
    }

    /// Takes in what happened, and what can be seen, and looks what is due.
    fn look_for(
        &self,
        event: Option<Event>,
        find: &impl Fn(&Ledger<P, G, T, S>, Instant) -> Found,
    ) -> Found {
        let mut changed = heapless::Vec::<Changed, TOLD>::new();
        let found = self.ledger.with(|ledger| {
            let now = ledger.clock.now();
            self.look_for_bars(ledger, now);
            let noticed = self.noticed(ledger);
            Self::record_safe_modes(ledger, now, &noticed);
            let events = [Event::Tick(now), noticed, self.faults()].into_iter().chain(event);
            ledger.books.steps(events, &mut ledger.actions);
            self.carry_out(ledger, now);
            while !changed.is_full() {
                let Some(change) = ledger.changed.pop() else { break };
                let _ = changed.push(change);
            }
            if ledger.changed.is_empty() { find(ledger, now) } else { Found::Changed }
        });
        // Not by value: a vector's own iterator has a panic path.
        for change in &changed {
            change.tell(&self.notify);
        }
        found.unwrap_or(Found::Due(None))
    }

    fn find(&self, ledger: &Ledger<P, G, T, S>, now: Instant) -> Found {
        let due = match ledger.books.work() {
            Ok(work) => return Found::Work(work),
            Err(due) => due,
        };
        let limits = self.keys.iter().enumerate().filter_map(|(number, key)| {
            let gate = GateId(u8::try_from(number).ok()?);
            let serial = ledger.books.device_report(gate)?.tenant?.serial;
            Some((key.look_again(now)?, gate, serial))
        });
        match limits.min_by_key(|(at, ..)| *at) {
            Some((at, gate, serial)) if at <= now => Found::Limit { gate, serial },
            next => Found::Due(due.into_iter().chain(next.map(|(at, ..)| at)).min()),
        }
    }

    /// The epochs are read before the books decide (Late Epoch Invariant).
    fn noticed(&self, ledger: &Ledger<P, G, T, S>) -> Event {
        let broker = self.scope.read();
        let agents = core::array::from_fn(|agent| {
            self.agents.get(agent).map_or_else(Default::default, super::Scope::read)
        });
        let mut survivors = 0;
        for number in 0..self.keys.len() {
            let Ok(gate) = u8::try_from(number).map(GateId) else { continue };
            let tenant = ledger.books.device_report(gate).and_then(|report| report.tenant);
            let Some(ticket) = tenant else { continue };
            let standing = self.standings.get(usize::from(ticket.seat));
            if standing.is_some_and(|standing| standing.survives(ticket.serial, broker.epoch)) {
                survivors |= crate::books::bit(gate);
            }
        }
        Event::Noticed { broker, agents, survivors }
    }

    fn record_safe_modes(ledger: &mut Ledger<P, G, T, S>, now: Instant, noticed: &Event) {
        let Event::Noticed { broker, agents, .. } = noticed else { return };
        for seen in ledger.books.ended(*broker, agents) {
            let floor = Priority::new(u8::try_from(seen.floor).unwrap_or(u8::MAX));
            let event = RecordedEvent::SafeMode { floor };
            ledger.lane.record(Record { at: now, ticket: 0, event });
        }
    }

    fn faults(&self) -> Event {
        let mut faults = [None; MAX_GATES];
        for (fault, key) in faults.iter_mut().zip(&self.keys) {
            *fault = key.fault();
        }
        Event::Faults(faults)
    }

    /// Finds who was barred: each standing that is ahead of the books' count.
    fn look_for_bars(&self, ledger: &mut Ledger<P, G, T, S>, now: Instant) {
        let bars = self.scope.take_bars();
        for seat in bars.seats(u16::try_from(T).unwrap_or(u16::MAX)) {
            let Some(standing) = self.standings.get(usize::from(seat)) else { continue };
            let epoch = standing.epoch_seen();
            let Some((serial, counted)) = ledger.books.counted(seat) else { continue };
            if epoch == counted {
                continue;
            }
            // One increment that meant somebody else is a bar that came too
            // late. With more than one, at least the doubt is the holder's.
            let stale = standing.barred_serial() != serial && epoch == counted.wrapping_add(1);
            let event = if stale || serial == 0 {
                Event::HitByStaleBar { seat, epoch }
            } else {
                Event::Barred { seat, epoch }
            };
            // Not decided on one by one: the step that follows knows of all.
            ledger.books.taken_in(event, &mut ledger.actions);
            self.carry_out(ledger, now);
        }
    }

    fn perform(&self, work: &Work) -> Option<Done> {
        let key = self.key(work.gate())?;
        let (tenure, result) = match *work {
            Work::Vacate { gate, tenure, timeout } => {
                let vacated = key.vacate(tenure, timeout);
                (tenure, vacated.map(|vacated| Done::Vacated { gate, ended: tenure, vacated }))
            }
            Work::Safe { gate, tenure, attempt, timeout } => {
                let safed = key.safe(tenure, attempt, timeout);
                (tenure, safed.map(|safed| Done::Safed { gate, tenure, attempt, safed }))
            }
            Work::SeenOff { gate, tenure, at, timeout } => {
                let told = key.seen_off(tenure, at, timeout);
                (tenure, told.map(|()| Done::SeenOff { gate, at }))
            }
            Work::Admit { tenure, .. } => (tenure, self.admit(key, work)?),
        };
        let gate = work.gate();
        Some(result.unwrap_or_else(|blocked| Done::Blocked { gate, tenure, blocked }))
    }

    fn admit(
        &self,
        key: &Key<'g>,
        work: &Work,
    ) -> Option<Result<Done, faregate_tickets::gate::Blocked>> {
        let Work::Admit { gate, tenure: after, ticket, validity, agent, stamp, timeout } = *work
        else {
            return None;
        };
        let standing = self.standings.get(usize::from(ticket.seat))?;
        #[cfg(feature = "mutant-lost-bar")]
        let stamp = stamp.map(|stamp| Stamp { own: standing.epoch_seen(), ..stamp });
        let stamp = stamp.map(|stamp| (standing, stamp));
        let admission = Admission { serial: ticket.serial, tenure: after, agent, validity, stamp };
        let admitted = key.admit(admission, timeout);
        Some(admitted.map(|tenure| Done::Admitted { gate, after, tenure, ticket }))
    }

    fn look_at_limit(&self, gate: GateId, serial: usize) -> Option<Event> {
        let key = self.key(gate)?;
        let ran_out = key.ran_out(serial, key.profile().patience())?;
        Some(Event::RanOut { gate, serial, ends_ticket: ran_out.ends_ticket })
    }
}
