//! What the books know of one device: how far it is from drawing nothing.

use faregate_tickets::clock::Instant;
use faregate_tickets::device::{Estimate, Profile, WhenOrphaned};
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::validity::Validity;

use crate::policy::Categories;

use super::{Actions, Noted};

/// Where a device stands between being granted and being seen off.
///
/// ```text
///        admit          admitted
///  Off --------> Admitting ----> Held
///   ^                |             | revoked, relinquished, run out
///   |                v             v
///   | seen off     Leaving <-------+
///   |                | vacated: quiescent
///   |                v
///   +------------- Idle ---> Confirming
///                    ^  safed    |
///                    +-----------+ not seen off in time
/// ```
///
/// Everything but `Off` is charged. From `Off`, `Idle` and `Confirming` the gate
/// can be granted to another ticket, and the charge passes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Phase {
    /// Freshly seen off, or of a kind that is not charged.
    Off,
    /// Granted; its gate is to admit the tenant.
    Admitting,
    /// Granted, and admitted.
    Held,
    /// Revoked; its gate is to be vacated. If hung, not before `retry_at`.
    Leaving { hung: bool, retry_at: Instant },
    /// Quiescent, and may be on.
    Idle,
    /// Made safe; to be seen off by then.
    Confirming { until: Instant },
}

/// Who used the device last: the integral of that ticket's budget runs until
/// the device is seen off.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum LastUser {
    Nobody,
    /// A grant that lives.
    Grant {
        seat: u16,
        serial: usize,
    },
    /// A grant that is gone, with what it left of its budgets.
    Gone {
        serial: usize,
        validity: Validity,
    },
}

impl From<TicketId> for LastUser {
    fn from(ticket: TicketId) -> Self {
        Self::Grant { seat: ticket.seat, serial: ticket.serial }
    }
}

impl LastUser {
    /// Whether it is this grant, which lives. (To compare it as a whole would
    /// be to compare validity functions.)
    pub(crate) fn is(&self, ticket: TicketId) -> bool {
        matches!(*self, Self::Grant { seat, serial } if TicketId { seat, serial } == ticket)
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct DeviceBook {
    pub(crate) agent: u8,
    pub(crate) profile: Profile,
    pub(crate) categories: Categories,
    pub(crate) phase: Phase,
    /// The number of its gate's latest change of tenant, as reported.
    pub(crate) tenure: usize,
    /// The seat to which it is granted (`Admitting`, `Held`).
    pub(crate) tenant: Option<u16>,
    /// The agent's epoch that was read before the grant.
    pub(crate) agent_stamp: usize,
    /// The number of the latest safing attempt in this tenure, as its gate
    /// counts them.
    pub(crate) attempts: u8,
    /// How many attempts failed since it was vacated, seen off or reset.
    pub(crate) failed: u8,
    /// Made safe as often as declared, and not seen off since. A ticket can use
    /// it all the same; to take that ticket would free nothing.
    pub(crate) stuck: bool,
    /// Measurements later than this say something about now.
    pub(crate) counts_from: Instant,
    pub(crate) seen: Option<Estimate>,
    /// To be made safe whether or not anybody needs what it draws.
    pub(crate) must_safe: bool,
    /// Somebody needs what it draws.
    pub(crate) needed_off: bool,
    pub(crate) fault: Option<GateFault>,
    /// Its gate is to be told that it was seen off at this instant.
    pub(crate) tell_off: Option<Instant>,
    /// Nobody has it, and its gate knows that it is off.
    pub(crate) told_off: bool,
    pub(crate) last_user: LastUser,
}

impl DeviceBook {
    pub(crate) fn new(agent: u8, profile: Profile, categories: Categories, now: Instant) -> Self {
        Self {
            agent,
            profile,
            categories,
            phase: Phase::Idle,
            tenure: 0,
            tenant: None,
            agent_stamp: 0,
            attempts: 0,
            failed: 0,
            stuck: false,
            counts_from: now,
            seen: None,
            must_safe: profile.when_orphaned == WhenOrphaned::SafeAtOnce,
            needed_off: false,
            fault: None,
            tell_off: None,
            told_off: false,
            last_user: LastUser::Nobody,
        }
    }

    /// A device that is not charged need not be seen off.
    pub(crate) fn settle_uncharged(&mut self) {
        self.phase = Phase::Off;
    }

    /// It is not granted any more; its gate is to be vacated.
    pub(crate) fn leave(&mut self) {
        if matches!(self.phase, Phase::Admitting | Phase::Held) {
            self.phase = Phase::Leaving { hung: false, retry_at: Instant::START };
        }
        self.tenant = None;
    }

    /// Nobody holds a ticket for it any more, and it may be on.
    pub(crate) fn orphaned(&mut self) {
        self.must_safe |= self.profile.when_orphaned == WhenOrphaned::SafeAtOnce;
    }

    /// Whether it goes off as soon as nobody has it, charged or not.
    pub(crate) fn is_safed_unless_held(&self) -> bool {
        self.profile.when_orphaned == WhenOrphaned::SafeUnlessHeld
    }

    /// Whether its commands may be in progress, or its ticket valid.
    pub(crate) fn is_quiescent(&self) -> bool {
        !matches!(self.phase, Phase::Admitting | Phase::Held | Phase::Leaving { .. })
    }

    /// Whether a ticket can be admitted now: quiescent, and not to be made safe
    /// first.
    pub(crate) fn is_admissible(&self) -> bool {
        let safe_first = self.must_safe && self.phase != Phase::Off && !self.stuck;
        self.is_quiescent() && !safe_first
    }

    /// Whether its charge cannot be freed by anybody.
    pub(crate) fn is_immovable(&self) -> bool {
        self.stuck || self.is_hung()
    }

    /// Whether a command that was to end with its ticket has not come back.
    pub(crate) fn is_hung(&self) -> bool {
        matches!(self.phase, Phase::Leaving { hung: true, .. })
    }

    /// Whether sensors are expected to see it off.
    pub(crate) fn is_observable(&self) -> bool {
        !self.profile.draw.is_zero() || !self.categories.is_empty()
    }

    /// The safing attempt that just ended has failed.
    pub(crate) fn attempt_failed<const G: usize>(
        &mut self,
        gate: GateId,
        actions: &mut Actions<G>,
    ) {
        self.phase = Phase::Idle;
        self.failed = self.failed.saturating_add(1);
        if self.failed >= self.profile.safing_attempts.max(1) {
            self.stuck = true;
            self.must_safe = false;
            actions.noted.push(Noted::Stuck(gate));
        }
    }
}
