//! A grant's standing: the few words through which it is revoked and checked.

use crate::id::{HolderId, Priority, TicketId};
use crate::sync::{AtomicUsize, Ordering};

/// What is published of the grant in one seat of the broker's table.
///
/// | word | who writes | meaning |
/// |---|---|---|
/// | `epoch` | the agent (pre-empts), supervisors (bar) | grows; each increment revokes |
/// | `stamp` | the agent, under a gate's lock | the own epoch at which the grant was made valid |
/// | `broker_stamp` | the agent, under a gate's lock | the broker's epoch that it had read before it decided |
/// | `barred` | supervisors, before the increment | the serial that was meant |
/// | `occupant` | the agent | the serial of the grant that has the seat |
/// | `holder` | the agent | whose grant it is, by the mission's own number |
/// | `agents` | the agent | which agents its gates belong to, one bit each |
/// | `exempt_*` | the holder, in revoke-all-but-me | the broker's epoch that the holder made itself |
/// | `why_*` | the agent, before the increment | what the epoch in `explains` means |
///
/// A grant is valid while its stamps equal the epochs. Epochs only grow, so a
/// stamp that is read in the middle of being written can only look old.
///
/// They are native words: 64 bits on hosts, where they never wrap; on 32-bit
/// targets a stamp would have to lie unrefreshed through 2^32 revocations, and
/// each service step refreshes what it finds revoked.
#[derive(Debug)]
pub struct Standing {
    epoch: AtomicUsize,
    occupant: AtomicUsize,
    agents: AtomicUsize,
    holder: AtomicUsize,
    stamp: AtomicUsize,
    broker_stamp: AtomicUsize,
    barred: AtomicUsize,
    exempt_epoch: AtomicUsize,
    exempt_serial: AtomicUsize,
    why_explains: AtomicUsize,
    why_cause: AtomicUsize,
    why_taker: AtomicUsize,
}

/// Why a grant is not valid, as far as that can be told truly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Why {
    /// It has not been granted yet.
    NotYetGranted,
    /// A more important one took what it needs.
    Preempted {
        /// Who took it.
        by: TicketId,
        /// How important that one is.
        priority: Priority,
    },
    /// The supply fell below what was granted.
    SupplyFell,
    /// A set was extended, and is being granted anew.
    Extended,
    /// The device must rest before it may be used again.
    Resting,
    /// Its gate is faulted.
    GateFaulted,
    /// All tickets of its agent or broker were revoked.
    RevokedAll,
    /// A supervisor barred it.
    Barred,
    /// Its time, its budget or its lease has run out.
    Expired,
    /// Several revocations came together: no single name would be true.
    Unknown,
}

impl Why {
    fn pack(self) -> (usize, usize) {
        let plain = |code| (code, 0);
        match self {
            Self::NotYetGranted => plain(1),
            Self::SupplyFell => plain(2),
            Self::Extended => plain(3),
            Self::Resting => plain(4),
            Self::GateFaulted => plain(5),
            Self::RevokedAll => plain(6),
            Self::Barred => plain(7),
            Self::Expired => plain(8),
            Self::Unknown => plain(0),
            Self::Preempted { by, priority } => {
                let cause = 9 | usize::from(priority.level()) << 8 | usize::from(by.seat) << 16;
                (cause, by.serial)
            }
        }
    }

    fn unpack(cause: usize, taker: usize) -> Self {
        let [code, level, low, high, ..] = cause.to_le_bytes();
        match code {
            1 => Self::NotYetGranted,
            2 => Self::SupplyFell,
            3 => Self::Extended,
            4 => Self::Resting,
            5 => Self::GateFaulted,
            6 => Self::RevokedAll,
            7 => Self::Barred,
            8 => Self::Expired,
            9 => Self::Preempted {
                by: TicketId { seat: u16::from_le_bytes([low, high]), serial: taker },
                priority: Priority::new(level),
            },
            _ => Self::Unknown,
        }
    }
}

/// The own and the broker's epoch that somebody read before deciding, to be
/// stamped when the decision is carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stamp {
    /// The grant's own epoch, as the agent counted it.
    pub own: usize,
    /// The broker's epoch, as it was read.
    pub broker: usize,
}

impl Standing {
    /// The standing of an empty seat: nothing is valid in it.
    #[must_use]
    pub fn new() -> Self {
        let zero = || AtomicUsize::new(0);
        Self {
            epoch: AtomicUsize::new(1),
            occupant: zero(),
            agents: zero(),
            holder: zero(),
            stamp: zero(),
            broker_stamp: zero(),
            barred: zero(),
            exempt_epoch: zero(),
            exempt_serial: zero(),
            why_explains: AtomicUsize::new(1),
            why_cause: AtomicUsize::new(1),
            why_taker: zero(),
        }
    }

    /// Revokes the grant, for the agent: it alone writes reasons, under its
    /// lock.
    ///
    /// # Timing
    /// Constant: atomic stores and one atomic increment.
    pub fn revoke(&self, why: Why) {
        // Relaxed: a bar that comes in between makes the reason stale, which
        // the reader detects; it never makes it wrong.
        let next = self.epoch.load(Ordering::Relaxed).wrapping_add(1);
        self.explain(next, why);
        // Release: who acquires this epoch sees the reason stored before it.
        self.epoch.fetch_add(1, Ordering::Release);
    }

    /// Gives the seat to the grant with this serial, for the agent.
    pub fn seat(&self, serial: usize, agents: usize) {
        // Relaxed: a holder of the old grant may still see its own serial
        // here, and the reason that was true of it.
        self.barred.store(0, Ordering::Relaxed);
        let epoch = self.epoch.load(Ordering::Relaxed);
        self.explain(epoch, Why::NotYetGranted);
        self.agents.store(agents, Ordering::Relaxed);
        // Release: who reads a reason and then finds another occupant knows
        // that the reason may not be its own.
        self.occupant.store(serial, Ordering::Release);
    }

    /// Names the holder of the grant that is about to be seated.
    pub fn set_holder(&self, holder: HolderId) {
        // Relaxed: ordered before the occupant by that one's Release.
        self.holder.store(usize::from(holder.0), Ordering::Relaxed);
    }

    /// The serial of the grant in this seat, if it is this holder's.
    #[must_use]
    pub fn occupant_of(&self, holder: HolderId) -> Option<usize> {
        // Acquire: pairs with the Release in `seat`. Should the seat change
        // hands after this, a bar with this serial is found to be stale.
        let serial = self.occupant.load(Ordering::Acquire);
        let theirs = self.holder.load(Ordering::Relaxed) == usize::from(holder.0);
        (serial != 0 && theirs).then_some(serial)
    }

    /// Names the agents that its gates belong to, when it has got more of them.
    pub fn set_agents(&self, agents: usize) {
        self.agents.store(agents, Ordering::Relaxed);
    }

    /// The agents that its gates belong to, one bit each.
    #[must_use]
    pub fn agents(&self) -> usize {
        // Relaxed: it says who has authority over the ticket. One that is being
        // extended at this moment may belong to one agent more.
        self.agents.load(Ordering::Relaxed)
    }

    /// Revokes the grant and takes its seat from it, for the agent.
    pub fn end(&self) {
        self.revoke(Why::Expired);
        self.occupant.store(0, Ordering::Release);
    }

    /// Whether the grant with this serial has the seat.
    #[must_use]
    pub fn is_occupied_by(&self, serial: usize) -> bool {
        // Relaxed: where it matters (a bar), the agent looks again.
        self.occupant.load(Ordering::Relaxed) == serial
    }

    /// Says what the present epoch means, without revoking anything more.
    pub fn explain_now(&self, epoch: usize, why: Why) {
        self.explain(epoch, why);
    }

    fn explain(&self, epoch: usize, why: Why) {
        let (cause, taker) = why.pack();
        // A reader takes the reason only if it finds the same epoch before and
        // after it: Release orders each store after the one that unsettles it.
        #[cfg(not(feature = "mutant-torn-reason"))]
        self.why_explains.store(0, Ordering::Relaxed);
        crate::sync::fence(Ordering::Release);
        self.why_cause.store(cause, Ordering::Relaxed);
        self.why_taker.store(taker, Ordering::Relaxed);
        self.why_explains.store(epoch, Ordering::Release);
    }

    /// Bars the grant with this serial, for a supervisor.
    ///
    /// The serial that was meant is stored first: should the seat have changed
    /// hands meanwhile, the agent sees who was meant and restores who was hit.
    ///
    /// # Timing
    /// Constant: one atomic store, one atomic increment; nobody can delay it.
    pub fn bar(&self, serial: usize) {
        // Relaxed, ordered before the increment by its Release.
        self.barred.store(serial, Ordering::Relaxed);
        self.epoch.fetch_add(1, Ordering::Release);
    }

    /// The serial that the latest bar meant.
    #[must_use]
    pub fn barred_serial(&self) -> usize {
        // Relaxed: read after `epoch_seen`, whose Acquire orders it.
        self.barred.load(Ordering::Relaxed)
    }

    /// Forgets a bar, when its grant leaves the seat or is reinstated.
    pub fn forget_bar(&self) {
        // Relaxed: the agent's own bookkeeping, under its lock.
        self.barred.store(0, Ordering::Relaxed);
    }

    /// The own epoch, for the agent that compares it with its own count.
    #[must_use]
    pub fn epoch_seen(&self) -> usize {
        // Acquire: pairs with `bar`, whose serial is read next.
        self.epoch.load(Ordering::Acquire)
    }

    /// Makes the grant valid for as long as nobody revokes it. Called under the
    /// lock of its (last) gate, with epochs read before the decision.
    pub(crate) fn stamp(&self, stamp: Stamp) {
        // Relaxed: holders look under the same gate's lock; who looks without
        // it sees an old stamp at worst, and is refused.
        self.broker_stamp.store(stamp.broker, Ordering::Relaxed);
        self.stamp.store(stamp.own, Ordering::Relaxed);
    }

    /// The word that a revocation changes.
    pub(crate) fn word(&self) -> &AtomicUsize {
        &self.epoch
    }

    pub(crate) fn own_is_current(&self) -> bool {
        // Relaxed: the argument of `Scope::epoch`.
        self.stamp.load(Ordering::Relaxed) == self.epoch.load(Ordering::Relaxed)
    }

    pub(crate) fn broker_is_current(&self, serial: usize, epoch: usize) -> bool {
        self.broker_stamp.load(Ordering::Relaxed) == epoch || self.is_exempt(serial, epoch)
    }

    fn is_exempt(&self, serial: usize, epoch: usize) -> bool {
        // Relaxed: only the holder writes these, and the holder is who asks.
        self.exempt_epoch.load(Ordering::Relaxed) == epoch
            && self.exempt_serial.load(Ordering::Relaxed) == serial
    }

    /// The holder, valid at `epoch`, is about to end that epoch itself.
    pub(crate) fn announce_exempt(&self, serial: usize, epoch: usize) {
        self.exempt_serial.store(serial, Ordering::Relaxed);
        // Release: the agent, which acquires this, must see the serial.
        self.exempt_epoch.store(epoch.wrapping_add(1), Ordering::Release);
    }

    /// Whether the holder with this serial survives the change to `epoch`, for
    /// the agent: it made that change itself, or has announced the next one,
    /// which it does only while valid.
    #[must_use]
    pub fn survives(&self, serial: usize, epoch: usize) -> bool {
        // Acquire: pairs with `announce_exempt`.
        let exempt = self.exempt_epoch.load(Ordering::Acquire);
        (exempt == epoch || exempt == epoch.wrapping_add(1))
            && self.exempt_serial.load(Ordering::Relaxed) == serial
    }

    /// Why the grant with this serial is not valid now.
    #[inline]
    pub(crate) fn why(&self, serial: usize) -> Why {
        // Acquire: pairs with the Release increments, so the reason read next
        // is at least as new as this epoch.
        let epoch = self.epoch.load(Ordering::Acquire);
        let explains = self.why_explains.load(Ordering::Acquire);
        let cause = self.why_cause.load(Ordering::Relaxed);
        let taker = self.why_taker.load(Ordering::Relaxed);
        // Pairs with the fence in `explain`: had a newer reason begun to be
        // written, its 0 or its epoch would be seen here.
        crate::sync::fence(Ordering::Acquire);
        let still = self.why_explains.load(Ordering::Relaxed);
        if !self.is_occupied_by(serial) {
            // The only way to lose a seat while the ticket lives.
            return Why::Expired;
        }
        if explains == epoch && still == epoch {
            return Why::unpack(cause, taker);
        }
        let barred = self.barred.load(Ordering::Relaxed) == serial;
        if barred { Why::Barred } else { Why::Unknown }
    }
}

impl Default for Standing {
    fn default() -> Self {
        Self::new()
    }
}
