//! Tickets: a holder's authority to issue commands through one gate.

use core::fmt;

use crate::device::Device;
use crate::fault::GateFault;
use crate::gate::{Gate, WayOf};
use crate::id::{GateId, Priority, TicketId};
use crate::platform::{Containment, Platform};
use crate::recorder::{Counts, Unrecorded};
use crate::refusal::{InvokeError, Refusal};
use crate::scope::Scope;
use crate::standing::Standing;

/// To whom a ticket goes back.
pub trait Issuer: Sync {
    /// The ticket with this seat is given back, with what it has counted and
    /// not recorded yet.
    ///
    /// Anybody can call this, with a seat of their own making. What nobody else
    /// can point to is the issuer's own scope: a seat without it is ignored.
    ///
    /// # Timing
    /// Called from `Drop`: it unlinks and marks, waits at most for one step of
    /// the books, and leaves the device to the next service.
    fn relinquish(&self, seat: &Seat<'_>, counted: Unrecorded, holder: Holder);
}

/// What became of the holder of a ticket that is given back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Holder {
    /// It gave the ticket back of its own will.
    Lives,
    /// It is unwinding. Its device is made safe at once.
    Died,
}

/// Where a ticket's validity is decided: its grant's standing, and the scopes
/// that can revoke it with others.
#[derive(Clone, Copy, Debug)]
pub struct Seat<'a> {
    /// Which grant.
    pub id: TicketId,
    /// Which gate of it.
    pub gate: GateId,
    /// The grant's standing.
    pub standing: &'a Standing,
    /// The agent's scope.
    pub agent: &'a Scope,
    /// The broker's scope.
    pub broker: &'a Scope,
}

/// A holder's authority to issue commands through one gate.
///
/// It can be sent to another thread, but not shared, copied or forged. Dropping
/// it relinquishes it, unwinding included.
///
/// The ticket may be revoked at any moment, by whoever its agent finds more
/// important. It stays in its holder's hands, refuses every command while it is
/// not valid, and may become valid again without being asked for.
pub struct Ticket<'a, D: Device, P: Platform, A: Issuer> {
    gate: &'a Gate<'a, D, P>,
    way: WayOf<'a, D, P>,
    seat: Seat<'a>,
    issuer: &'a A,
    /// Its cells also keep the ticket from being shared between threads.
    counts: Counts,
}

impl<'a, D: Device, P: Platform, A: Issuer> Ticket<'a, D, P, A> {
    pub(crate) fn new(gate: &'a Gate<'a, D, P>, seat: Seat<'a>, issuer: &'a A) -> Self {
        let way = gate.way(&seat);
        Self { gate, way, seat, issuer, counts: Counts::default() }
    }

    /// Issues the command, if the ticket is valid and its validity function
    /// agrees.
    ///
    /// # Errors
    /// [`InvokeError::Refused`] if the device has not seen the command, with
    /// the reason; [`InvokeError::Fault`] if its driver faulted on it.
    ///
    /// # Timing
    /// A ticket that is not valid is refused after a constant number of atomic
    /// loads. An admitted command waits for at most
    /// the one check, command or safing in progress at the gate, with priority
    /// inheritance where the gate's strategy has it; beside the driver's own
    /// time the rest is constant: no loop, no allocation.
    ///
    /// # After revocation
    /// Refused, from the first invocation that happens after the revocation.
    /// One that was admitted before it may still be in progress; who revoked
    /// waits for quiescence.
    #[inline]
    pub fn invoke(&self, command: D::Command) -> Result<D::Response, InvokeError<D::Fault>> {
        match self.store(&command) {
            Some(response) => Ok(response),
            None => self.enter(command),
        }
    }

    /// Like [`invoke`](Ticket::invoke), but says [`Refusal::Busy`] instead of
    /// waiting.
    ///
    /// # Errors
    /// As [`invoke`](Ticket::invoke).
    ///
    /// # Timing
    /// Constant, beside the driver's own time.
    ///
    /// # After revocation
    /// As [`invoke`](Ticket::invoke).
    pub fn try_invoke(&self, command: D::Command) -> Result<D::Response, InvokeError<D::Fault>> {
        if let Some(response) = self.store(&command) {
            return Ok(response);
        }
        if let Err(fault) = self.seen() {
            return self.refuse(fault);
        }
        let result = self.gate.try_invoke(&self.way, command, &self.counts, || self.look());
        self.count_refused(&result);
        result
    }

    /// Renews the lease.
    ///
    /// # Errors
    /// The reason, if the ticket is not valid.
    ///
    /// # Timing
    /// As [`invoke`](Ticket::invoke), without a command.
    ///
    /// # After revocation
    /// Refused: what is not valid has no lease that runs.
    pub fn renew(&self) -> Result<(), Refusal> {
        self.gate.renew(&self.way, || self.look())
    }

    /// Whether the ticket is valid at this instant, and if not, why.
    ///
    /// The answer can be old when it arrives: a valid ticket may be revoked
    /// before the next instruction, and a waiting one restored. It may be
    /// shown, and a loop may end on it; only [`invoke`](Ticket::invoke) decides.
    ///
    /// # Errors
    /// The reason why an invocation would be refused.
    ///
    /// # Timing
    /// A constant number of atomic loads.
    ///
    /// # After revocation
    /// Says why, until the ticket is restored.
    pub fn check(&self) -> Result<(), Refusal> {
        self.look().map(|_| ())
    }

    /// How often this ticket's seat has been revoked so far. Two different
    /// answers say that the ticket was revoked in between, even where it is
    /// valid again: what its device was told before may not be so any more.
    ///
    /// # Timing
    /// One atomic load.
    pub fn revocations(&self) -> usize {
        self.seat.standing.epoch_seen()
    }

    /// The ticket's identity, for supervisors and records.
    pub fn id(&self) -> TicketId {
        self.seat.id
    }

    /// Whether it is this issuer's: another one can have a ticket with the same
    /// identity.
    pub fn is_of(&self, issuer: &A) -> bool {
        core::ptr::eq(self.issuer, issuer)
    }

    /// Gives the ticket back. Dropping it does the same.
    ///
    /// # Timing
    /// Waits at most for one step of the books.
    pub fn relinquish(self) {}

    /// Revokes every ticket of the broker except this one, for a supervisor
    /// who holds it. Answers whether this one is still valid: only a ticket
    /// that was valid when the epoch ended is exempt.
    ///
    /// The agent offers this with its supervisor; on its own it needs the
    /// scope, which only the broker has. Nothing else below `floor` becomes
    /// valid until safe mode is left.
    ///
    /// # Timing
    /// Constant: a look, three stores, one atomic increment, a look.
    pub fn revoke_all_but_me(&self, broker: &Scope, floor: Priority) -> bool {
        if !core::ptr::eq(broker, self.seat.broker) {
            return false;
        }
        let serial = self.seat.id.serial;
        let epoch = broker.epoch();
        let valid = self.look().is_ok();
        // Exempt by Announcement Invariant: the exemption names the epoch that
        // this very increment makes. If somebody else's comes first, it names
        // theirs, but this thread does not invoke before its own increment has
        // made it void.
        #[cfg(not(feature = "mutant-exempt-by-name"))]
        if valid {
            self.seat.standing.announce_exempt(serial, epoch);
        }
        broker.set_floor(floor);
        let ended = broker.revoke_all_after();
        #[cfg(feature = "mutant-exempt-by-name")]
        self.seat.standing.announce_exempt(serial, ended);
        let _ = ended;
        self.look().is_ok()
    }

    /// Invokes by the gate's lock, or past it.
    fn enter(&self, command: D::Command) -> Result<D::Response, InvokeError<D::Fault>> {
        if let Err(fault) = self.seen() {
            return self.refuse(fault);
        }
        let result = self.gate.invoke(&self.way, command, &self.counts, || self.look());
        self.count_refused(&result);
        result
    }

    /// Does a command that is no more than its store, if that is in order. When
    /// no more can be counted the next one goes by the lock, which tells the count.
    #[inline(always)]
    fn store(&self, command: &D::Command) -> Option<D::Response> {
        let response = self.gate.store(&self.way, command)?;
        if self.counts.store() == u32::MAX {
            self.gate.step_back(&self.way);
        }
        Some(response)
    }

    /// What the look before the gate comes to, where it does not agree. The
    /// reason is written where the caller wants it: the holder of a ticket that
    /// is not valid may try again and again.
    #[cold]
    #[inline(never)]
    fn refuse(&self, fault: usize) -> Result<D::Response, InvokeError<D::Fault>> {
        self.gate.step_back(&self.way);
        self.counts.refuse();
        Err(InvokeError::Refused(self.explain(fault)))
    }

    /// The look that counts, inside. Whoever is refused here was revoked since
    /// the look before: that is rare, and kept out of the way.
    #[inline(always)]
    fn look(&self) -> Result<usize, Refusal> {
        self.seen().map_err(|fault| self.explain_apart(fault))
    }

    /// Whether the ticket is valid: the serial that the gate must have as its
    /// tenant, and every stamp current; else the gate's fault, as a code.
    // Always: it is a dozen loads and compares, twice in each invocation, and
    // as a call it would hand its answer over in memory.
    #[inline(always)]
    fn seen(&self) -> Result<usize, usize> {
        let Seat { id, standing, agent, broker, .. } = self.seat;
        let (tenant, admitted_at) = self.gate.tenant();
        let epoch = broker.epoch();
        let valid = (cfg!(feature = "mutant-any-tenant") || tenant == id.serial)
            && standing.is_occupied_by(id.serial)
            && standing.own_is_current()
            && admitted_at == agent.epoch()
            && standing.broker_is_current(id.serial, epoch);
        let fault = self.gate.fault_code();
        if valid && fault == 0 { Ok(id.serial) } else { Err(fault) }
    }

    #[cold]
    #[inline(never)]
    fn explain_apart(&self, fault: usize) -> Refusal {
        self.explain(fault)
    }

    #[inline]
    fn explain(&self, fault: usize) -> Refusal {
        if let Some(fault) = GateFault::from_code(fault) {
            return Refusal::Faulted(fault);
        }
        let Seat { id, standing, agent, broker, .. } = self.seat;
        let seated = standing.is_occupied_by(id.serial) && standing.own_is_current();
        if !seated || self.gate.tenant().0 != id.serial {
            return Refusal::NotValid(standing.why(id.serial));
        }
        let floors = [broker.floor(), agent.floor()];
        let floor = floors.into_iter().flatten().max_by_key(|floor| floor.level());
        Refusal::RevokedAll { floor }
    }

    fn count_refused(&self, result: &Result<D::Response, InvokeError<D::Fault>>) {
        if let Err(InvokeError::Refused(_)) = result {
            self.counts.refuse();
        }
    }
}

impl<D: Device, P: Platform, A: Issuer> Drop for Ticket<'_, D, P, A> {
    fn drop(&mut self) {
        let died = P::Containment::is_unwinding();
        let holder = if died { Holder::Died } else { Holder::Lives };
        self.issuer.relinquish(&self.seat, self.counts.get(), holder);
    }
}

impl<D: Device, P: Platform, A: Issuer> fmt::Debug for Ticket<'_, D, P, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ticket").field("id", &self.seat.id).finish_non_exhaustive()
    }
}

#[cfg(all(test, feature = "lock-api", not(loom)))]
mod tests {
    extern crate std;
    use super::*;
    use crate::clock::{Clock, Duration, Instant};
    use crate::device::{Declaration, Effect, Profile};
    use crate::gate::Admission;
    use crate::lock::{Locked, Outcome, Restartable, Sections, Watch};
    use crate::recorder::{Lane, Record, RecordedEvent};
    use crate::standing::Stamp;
    use crate::validity::Validity;
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
    use std::{boxed::Box, sync::mpsc};

    enum Alone {}

    impl Sections for Alone {
        fn store(watch: &Watch<'_>, register: &AtomicU32, word: u32) -> Outcome {
            if !watch.is_as_expected() {
                return Outcome::Refused;
            }
            register.store(word, Relaxed);
            Outcome::Stored
        }
        fn end_all() -> bool {
            true
        }
    }

    struct Register(&'static AtomicU32);

    impl Device for Register {
        type Command = u32;
        type Response = ();
        type Fault = ();

        fn profile(&self) -> Profile {
            Profile::new()
        }
        fn declare(_: &u32) -> Declaration {
            Declaration { code: 5, wcet: Duration::from_millis(1), effect: Effect::Unchanged }
        }
        fn issue(&mut self, word: u32) -> Result<(), ()> {
            self.0.store(word, Relaxed);
            Ok(())
        }
        fn safe(&mut self) -> Result<(), ()> {
            Ok(())
        }
        fn register(&self) -> Option<&'static AtomicU32> {
            Some(self.0)
        }
        fn word(word: &u32) -> Option<(u32, ())> {
            Some((*word, ()))
        }
    }

    struct Stopped;

    impl Clock for Stopped {
        fn now(&self) -> Instant {
            Instant::START
        }
    }

    struct Tape(mpsc::Sender<RecordedEvent>);

    impl Lane for Tape {
        fn record(&mut self, record: Record) {
            let _ = self.0.send(record.event);
        }
    }

    struct Nobody;

    impl Issuer for Nobody {
        fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
    }

    type Inner = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

    #[test]
    fn no_store_is_lost_where_no_more_can_be_counted() {
        let register: &AtomicU32 = Box::leak(Box::default());
        let (tape, told) = mpsc::channel();
        let (standing, scope) = (Standing::new(), Scope::new());
        let id = TicketId { seat: 0, serial: 1 };
        standing.seat(id.serial, 1);
        let mut gate = Gate::<_, (Restartable<Inner, Alone>, _, _)>::new(
            Register(register),
            Stopped,
            Tape(tape),
        );
        let (key, handle) = gate.key().split();
        let seat = Seat { id, gate: GateId(0), standing: &standing, agent: &scope, broker: &scope };
        let mut ticket = key.ticket(handle, seat, &Nobody).unwrap();
        let stamp = Stamp { own: standing.epoch_seen(), broker: scope.read().epoch };
        let admission = Admission {
            serial: id.serial,
            tenure: 0,
            agent: stamp.broker,
            validity: Validity::always(),
            stamp: Some((&standing, stamp)),
        };
        key.admit(admission, Duration::MAX).unwrap();
        ticket.invoke(1).unwrap();
        ticket.counts = Counts::with_stores(u32::MAX - 1);
        for word in 2..=4 {
            ticket.invoke(word).unwrap();
        }
        // What was full was told by the lock, and counts anew.
        assert_eq!(ticket.counts.get(), Unrecorded { refused: 0, stored: 1 });
        let issued = RecordedEvent::Issued { code: 5 };
        let stored = RecordedEvent::Stored { count: u32::MAX };
        let events: std::vec::Vec<_> = told.try_iter().skip(1).collect();
        assert_eq!(events, [issued, stored, issued]);
    }
}
