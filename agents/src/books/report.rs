//! What can be asked of the books, without changing them.

use faregate_tickets::amount::{Microjoules, Milligrams, Milliwatts};
use faregate_tickets::clock::Duration;
use faregate_tickets::device::Estimate;
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::{GateId, TicketId};

use crate::refusal::Waiting;

use super::device::{DeviceBook, Phase};
use super::grant::State;
use super::{Books, gates_of};

/// Where a device stands; see the picture in the books.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DeviceState {
    /// Seen off, or of a kind that is not charged. Everything else is charged.
    Off,
    /// Granted to a ticket.
    Granted,
    /// Revoked; a command may still be in progress.
    Leaving,
    /// Nobody's, and may be on.
    Orphaned,
    /// Made safe, and not seen off yet.
    Confirming,
    /// Made safe as often as declared, and not seen off; or its driver does not
    /// come back.
    Stuck,
}

/// What the books know of one device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DeviceReport {
    /// Where it stands.
    pub state: DeviceState,
    /// Whose it is.
    pub tenant: Option<TicketId>,
    /// What is charged for it.
    pub charge: Milliwatts,
    /// The latest estimate.
    pub seen: Option<Estimate>,
    /// Why its gate is faulted, if it is.
    pub fault: Option<GateFault>,
}

impl<const G: usize, const T: usize, const S: usize> Books<G, T, S> {
    /// What a ticket waits for; `None` if it is valid, or the id is stale.
    #[must_use]
    pub fn waiting_for(&self, ticket: TicketId) -> Option<Waiting> {
        let grant = self.grant_of(ticket)?;
        match grant.state {
            State::Valid => return None,
            State::Barred => return Some(Waiting::Barred),
            State::Resting(_) => return Some(Waiting::Resting),
            State::Granting => return Some(Waiting::HandOver),
            State::Waiting => {}
        }
        let below = self.floors(grant.gates).find(|seen| !seen.admits(grant.priority));
        if let Some(floor) = below.and_then(|seen| u8::try_from(seen.floor).ok()) {
            return Some(Waiting::SafeMode { floor: faregate_tickets::id::Priority::new(floor) });
        }
        Some(self.behind(ticket).or(grant.blocked).unwrap_or(Waiting::HandOver))
    }

    /// Who stands before a ticket in its gate's line.
    fn behind(&self, ticket: TicketId) -> Option<Waiting> {
        let grant = self.grant_of(ticket).filter(|grant| grant.set.is_none())?;
        let gate = gates_of(grant.gates).next()?;
        let first = u16::try_from(self.rosters.first(usize::from(gate.0))?).ok()?;
        let by = self.grant(first)?.id(first);
        (first != ticket.seat).then_some(Waiting::Gate { gate, by })
    }

    /// Whether the books have the ticket down as valid.
    #[must_use]
    pub fn is_valid(&self, ticket: TicketId) -> bool {
        self.grant_of(ticket).is_some_and(|grant| grant.state == State::Valid)
    }

    /// The gates of a ticket's grant, as bits; none if the id is stale.
    #[must_use]
    pub fn gates(&self, ticket: TicketId) -> u64 {
        self.grant_of(ticket).map_or(0, |grant| grant.gates)
    }

    /// The agents that a ticket's gates belong to, one bit each.
    #[must_use]
    pub fn agents_of(&self, ticket: TicketId) -> usize {
        let agents = gates_of(self.gates(ticket)).filter_map(|gate| self.device(gate));
        agents.fold(0, |bits, device| bits | 1 << device.agent)
    }

    /// The agent that a gate belongs to, by number.
    #[must_use]
    pub fn agent_of(&self, gate: GateId) -> Option<u8> {
        self.device(gate).map(|device| device.agent)
    }

    /// The serial of whoever has the seat (0 for nobody), and its own epoch as
    /// the books count it.
    #[must_use]
    pub fn counted(&self, seat: u16) -> Option<(usize, usize)> {
        self.grants.get(usize::from(seat)).map(|grant| (grant.serial, grant.own))
    }

    /// What the books know of a device.
    #[must_use]
    pub fn device_report(&self, gate: GateId) -> Option<DeviceReport> {
        let device = self.device(gate)?;
        let tenant = device.tenant.and_then(|seat| Some(self.grant(seat)?.id(seat)));
        let charge =
            if device.phase == Phase::Off { Milliwatts::ZERO } else { device.profile.draw };
        let (seen, fault) = (device.seen, device.fault);
        Some(DeviceReport { state: device.state(), tenant, charge, seen, fault })
    }

    /// The sum of an agent's charges now.
    #[must_use]
    pub fn charged(&self, agent: u8) -> Milliwatts {
        self.charges().get(usize::from(agent)).copied().unwrap_or_default()
    }

    /// An agent's supply.
    #[must_use]
    pub fn supply(&self, agent: u8) -> Option<Milliwatts> {
        self.agent(agent).filter(|agent| agent.policy.supply.is_some()).map(|agent| agent.supply)
    }

    /// What is left of an agent's consumables.
    #[must_use]
    pub fn budgets(&self, agent: u8) -> Option<(Microjoules, Milligrams)> {
        self.agent(agent).map(|agent| (agent.energy_left, agent.propellant_left))
    }

    /// How many seats are free.
    #[must_use]
    pub fn free_seats(&self) -> usize {
        self.grants.iter().filter(|grant| grant.serial == 0).count()
    }

    /// **Bounded Hand-over.** The longest time from a request for this gate at
    /// the highest priority until its ticket is valid, if as many rounds of
    /// victims are needed: one, and one more for each device that proves stuck.
    ///
    /// Per gate of its agent, vacating it; per round and attempt, issuing each
    /// safing command, and the longest settling and confirmation of all, which
    /// run side by side. To it comes the time of the steps themselves, a
    /// constant for each victim, which is the platform's.
    #[must_use]
    pub fn hand_over_bound(&self, gate: GateId, rounds: u32) -> Option<Duration> {
        let agent = self.device(gate)?.agent;
        let devices = || self.devices.iter().filter(move |device| device.agent == agent);
        let vacating = devices()
            .fold(Duration::ZERO, |sum, device| sum.saturating_add(device.profile.patience()));
        let attempts = devices().map(|device| device.profile.safing_attempts.max(1)).max()?;
        let safing = devices()
            .fold(Duration::ZERO, |sum, device| sum.saturating_add(device.profile.longest_safing));
        let confirming = devices()
            .map(|device| device.profile.settling.saturating_add(device.profile.estimate_lag))
            .max()?;
        let round = safing.saturating_add(confirming).saturating_mul(u64::from(attempts));
        Some(vacating.saturating_add(round.saturating_mul(u64::from(rounds))))
    }
}

impl DeviceBook {
    fn state(&self) -> DeviceState {
        match self.phase {
            Phase::Off => DeviceState::Off,
            Phase::Admitting | Phase::Held => DeviceState::Granted,
            Phase::Leaving { hung: false, .. } => DeviceState::Leaving,
            Phase::Idle if self.stuck => DeviceState::Stuck,
            Phase::Idle => DeviceState::Orphaned,
            Phase::Confirming { .. } => DeviceState::Confirming,
            Phase::Leaving { hung: true, .. } => DeviceState::Stuck,
        }
    }
}
