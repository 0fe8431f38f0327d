//! Arbitration: who of those who ask has what, the most important first.
//!
//! **Highest First.** Candidates are walked in the one total order (priority,
//! then arrival). Each is chosen, all or nothing, if it fits beside those chosen
//! before it and the devices that nobody can free. What is chosen is a function
//! of who asks and of what is stuck, and of nothing else: a victim is exactly a
//! grant that was not chosen, and the one that was chosen in its place is known
//! to suffice before anything is taken.
//!
//! The tickets of one gate need the same of its agent, so the first of its
//! roster is its only candidate: a decision costs what the gates and the sets
//! cost, never the tickets.
//!
//! **Margin Kept.** Being chosen is not being granted. A chosen request is
//! granted when its gates are quiescent and the charges *as they are now*, with
//! what more important chosen ones are still owed, leave room for it.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::id::GateId;
use faregate_tickets::scope::Seen;
use faregate_tickets::standing::Why;

use crate::limits::{MAX_AGENTS, MAX_GATES};
use crate::refusal::Waiting;

use super::device::{DeviceBook, LastUser, Phase};
use super::grant::State;
use super::{Actions, Books, bit, gates_of};

/// The heads of all rosters and all sets, in order.
type Candidates = heapless::Vec<u16, { 2 * MAX_GATES }>;

/// The draw counted for each agent.
type Draws = [Milliwatts; MAX_AGENTS];

/// Who was chosen for what.
struct Choice {
    /// The seat chosen for each gate.
    by_gate: [Option<u16>; MAX_GATES],
    /// The draws of all that was chosen, and of what cannot be freed.
    draws: Draws,
}

impl Choice {
    fn of(&self, gate: GateId) -> Option<u16> {
        self.by_gate.get(usize::from(gate.0)).copied().flatten()
    }

    fn has(&self, seat: u16, gates: u64) -> bool {
        gates_of(gates).next().is_some_and(|gate| self.of(gate) == Some(seat))
    }

    fn draw(&self, agent: u8) -> Milliwatts {
        self.draws.get(usize::from(agent)).copied().unwrap_or_default()
    }
}

fn add(draws: &mut Draws, agent: u8, draw: Milliwatts) {
    if let Some(sum) = draws.get_mut(usize::from(agent)) {
        *sum = sum.saturating_add(draw);
    }
}

impl<const G: usize, const T: usize, const S: usize> Books<G, T, S> {
    /// Decides anew, and sets in motion what the decision asks for.
    pub(super) fn arbitrate(&mut self, actions: &mut Actions<G>) {
        let candidates = self.candidates();
        let choice = self.choose(&candidates);
        self.preempt_unchosen(&candidates, &choice, actions);
        self.free_orphans(&choice);
        self.grant_chosen(&candidates, &choice);
    }

    fn candidates(&self) -> Candidates {
        let mut candidates = Candidates::new();
        for gate in 0..self.devices.len() {
            if let Some(seat) = self.head(gate) {
                self.insert(&mut candidates, seat);
            }
        }
        for set in &self.sets {
            if let Some(seat) = set.seat.filter(|seat| self.may_be_granted(*seat)) {
                self.insert(&mut candidates, seat);
            }
        }
        candidates
    }

    /// Keeps the candidates in order while they are collected: whoever is
    /// displaced displaces the next. (To insert in the middle of a vector is
    /// a copy whose length nothing in the code bounds.)
    fn insert(&self, candidates: &mut Candidates, seat: u16) {
        let rank = |seat: u16| self.grant(seat).map(super::Grant::rank);
        let mut displaced = seat;
        for place in candidates.iter_mut() {
            if rank(*place) > rank(displaced) {
                core::mem::swap(place, &mut displaced);
            }
        }
        // There is room for every gate and every set.
        let _ = candidates.push(displaced);
    }

    /// The first of a gate's roster; below the floor, only a tenant that is
    /// exempt.
    fn head(&self, gate: usize) -> Option<u16> {
        let first = self.rosters.first(gate).and_then(|seat| u16::try_from(seat).ok());
        let first = first.filter(|seat| self.may_be_granted(*seat));
        let tenant = || self.devices.get(gate)?.tenant.filter(|seat| self.may_be_granted(*seat));
        first
            .or_else(tenant)
            .filter(|seat| self.grant(*seat).is_some_and(|grant| grant.set.is_none()))
    }

    fn may_be_granted(&self, seat: u16) -> bool {
        let Some(grant) = self.grant(seat).filter(|grant| grant.is_eligible()) else {
            return false;
        };
        let admitted = self.floors(grant.gates).all(|seen| seen.admits(grant.priority));
        (grant.exempt || admitted) && !self.is_over(seat)
    }

    pub(super) fn floors(&self, gates: u64) -> impl Iterator<Item = Seen> {
        let agents = gates_of(gates).filter_map(|gate| self.agent(self.device(gate)?.agent));
        agents.map(|agent| agent.seen).chain(core::iter::once(self.broker_seen))
    }

    /// The greedy walk.
    fn choose(&mut self, candidates: &Candidates) -> Choice {
        let mut choice = Choice { by_gate: [None; MAX_GATES], draws: self.immovable_draws() };
        for seat in candidates {
            let blocked = self.blocked(*seat, &choice);
            #[cfg(feature = "mutant-taken-in-vain")]
            let blocked = blocked.filter(|why| !matches!(why, Waiting::Margin { .. }));
            if blocked.is_none() {
                self.choose_seat(*seat, &mut choice);
            }
            if let Some(grant) = self.grant_mut(*seat) {
                grant.blocked = blocked;
            }
        }
        choice
    }

    fn choose_seat(&self, seat: u16, choice: &mut Choice) {
        let Some(grant) = self.grant(seat) else { return };
        for gate in gates_of(grant.gates) {
            let Some(device) = self.device(gate) else { continue };
            if !device.is_immovable() {
                add(&mut choice.draws, device.agent, self.draw_of(device));
            }
            if let Some(slot) = choice.by_gate.get_mut(usize::from(gate.0)) {
                *slot = Some(seat);
            }
        }
    }

    fn immovable_draws(&self) -> Draws {
        let mut draws = Draws::default();
        for device in &self.devices {
            // A condition and no filter: of that the compiler makes two loops,
            // each of which goes on in the other.
            if device.is_immovable() {
                add(&mut draws, device.agent, self.draw_of(device));
            }
        }
        draws
    }

    /// What a device counts against its agent's supply.
    fn draw_of(&self, device: &DeviceBook) -> Milliwatts {
        let has_margin =
            self.agent(device.agent).is_some_and(|agent| agent.policy.supply.is_some());
        if has_margin { device.profile.draw } else { Milliwatts::ZERO }
    }

    /// Why a candidate cannot be chosen beside those chosen before it.
    fn blocked(&self, seat: u16, choice: &Choice) -> Option<Waiting> {
        let grant = self.grant(seat)?;
        let gates = grant.gates;
        let by_gate = gates_of(gates).find_map(|gate| self.gate_blocks(gate, choice));
        by_gate
            .or_else(|| self.neighbours_block(gates, choice))
            .or_else(|| self.margin_blocks(gates, choice))
    }

    fn gate_blocks(&self, gate: GateId, choice: &Choice) -> Option<Waiting> {
        let device = self.device(gate)?;
        if let Some(fault) = device.fault {
            return Some(Waiting::Faulted { gate, fault });
        }
        let by = choice.of(gate)?;
        Some(Waiting::Gate { gate, by: self.grant(by)?.id(by) })
    }

    /// Exclusion and categories look at the agent's other gates.
    fn neighbours_block(&self, gates: u64, choice: &Choice) -> Option<Waiting> {
        gates_of(gates).find_map(|gate| {
            let device = self.device(gate)?;
            let policy = self.agent(device.agent)?.policy;
            if !policy.exclusive && !policy.categories {
                return None;
            }
            self.neighbours(gates, device.agent).find_map(|(neighbour, other)| {
                let by = choice.of(neighbour).and_then(|by| Some(self.grant(by)?.id(by)));
                if let (true, Some(by)) = (policy.exclusive, by) {
                    return Some(Waiting::Exclusive { by });
                }
                let shared = device.categories.shared(other.categories);
                let used = by.is_some() || other.is_immovable();
                (policy.categories && used && !shared.is_empty())
                    .then_some(Waiting::Categories { shared, by })
            })
        })
    }

    /// The gates of an agent that are not among `gates`.
    fn neighbours(&self, gates: u64, agent: u8) -> impl Iterator<Item = (GateId, &DeviceBook)> {
        let all = self.devices.iter().enumerate();
        let named =
            all.filter_map(|(number, device)| Some((GateId(u8::try_from(number).ok()?), device)));
        named.filter(move |(gate, device)| gates & bit(*gate) == 0 && device.agent == agent)
    }

    fn margin_blocks(&self, gates: u64, choice: &Choice) -> Option<Waiting> {
        let movable = |device: &&DeviceBook| !device.is_immovable();
        let more = self.draws_of(gates, movable);
        self.agents.iter().enumerate().find_map(|(number, agent)| {
            agent.policy.supply?;
            let number = u8::try_from(number).ok()?;
            let wanted = *more.get(usize::from(number))?;
            let short_by = choice.draw(number).saturating_add(wanted).saturating_sub(agent.supply);
            // An agent of which nothing more is wanted blocks nobody, even while
            // its supply has fallen below what cannot be freed.
            (!wanted.is_zero() && !short_by.is_zero()).then_some(Waiting::Margin { short_by })
        })
    }

    fn draws_of(&self, gates: u64, counts: impl Fn(&&DeviceBook) -> bool) -> Draws {
        let mut draws = Draws::default();
        for device in
            gates_of(gates).filter_map(|gate| self.device(gate)).filter(|device| counts(device))
        {
            add(&mut draws, device.agent, self.draw_of(device));
        }
        draws
    }

    fn preempt_unchosen(
        &mut self,
        candidates: &Candidates,
        choice: &Choice,
        actions: &mut Actions<G>,
    ) {
        for number in 0..self.devices.len() {
            let tenant = self.devices.get(number).and_then(|device| device.tenant);
            let Some(seat) = tenant else { continue };
            let Some(gates) = self.grant(seat).map(|grant| grant.gates) else { continue };
            if !choice.has(seat, gates) {
                let why = self.why_preempted(seat, candidates, choice);
                self.preempt(seat, why, actions);
            }
        }
    }

    /// Who took what the grant had, as far as there is one true name.
    fn why_preempted(&self, seat: u16, candidates: &Candidates, choice: &Choice) -> Why {
        let Some(grant) = self.grant(seat) else { return Why::Unknown };
        // One that is not a candidate stands behind another in its gate's line,
        // and lost what that one has, or cannot have either.
        let blocked = if candidates.contains(&seat) {
            grant.blocked
        } else {
            gates_of(grant.gates).find_map(|gate| self.gate_blocks(gate, choice)).or_else(|| {
                let head = self.head(gates_of(grant.gates).next()?.0.into())?;
                self.grant(head)?.blocked
            })
        };
        let taker = match blocked {
            Some(Waiting::Faulted { .. }) => return Why::GateFaulted,
            Some(Waiting::Gate { by, .. } | Waiting::Exclusive { by }) => Some(by.seat),
            Some(Waiting::Categories { by, .. }) => by.map(|by| by.seat),
            Some(Waiting::Margin { .. }) => self.margin_taker(seat, candidates, choice),
            _ => None,
        };
        match taker.and_then(|taker| Some((taker, self.grant(taker)?))) {
            Some((seat, by)) => Why::Preempted { by: by.id(seat), priority: by.priority },
            None if self.floors(grant.gates).any(|seen| !seen.admits(grant.priority)) => {
                Why::RevokedAll
            }
            None => Why::SupplyFell,
        }
    }

    /// The most important one that was chosen, draws on the same supply, and
    /// has not got it yet.
    fn margin_taker(&self, victim: u16, candidates: &Candidates, choice: &Choice) -> Option<u16> {
        let lost = self.draws_of(self.grant(victim)?.gates, |_| true);
        let rank = |seat: u16| self.grant(seat).map(super::Grant::rank);
        let mut before = candidates.iter().copied().filter(|seat| rank(*seat) < rank(victim));
        before.find(|seat| {
            let Some(grant) = self.grant(*seat) else { return false };
            let draws = self.draws_of(grant.gates, |_| true);
            let shares =
                draws.iter().zip(&lost).any(|(own, lost)| !own.is_zero() && !lost.is_zero());
            choice.has(*seat, grant.gates) && !grant.is_granted() && shares
        })
    }

    /// Orphans go off if they must, if what was chosen leaves no room for them, or
    /// if that is declared of devices that nobody has.
    fn free_orphans(&mut self, choice: &Choice) {
        let mut draws = choice.draws;
        for number in 0..self.devices.len() {
            let Ok(gate) = u8::try_from(number).map(GateId) else { continue };
            let needed = self.orphan_is_needed(gate, choice, &mut draws);
            if let Some(device) = self.device_mut(gate) {
                device.needed_off = needed;
            }
        }
    }

    fn orphan_is_needed(&self, gate: GateId, choice: &Choice, draws: &mut Draws) -> bool {
        let Some(device) = self.device(gate) else { return false };
        let orphan = device.phase == Phase::Idle && !device.stuck && choice.of(gate).is_none();
        let Some(agent) = self.agent(device.agent).filter(|_| orphan) else { return false };
        let conflicts = agent.policy.categories
            && self.neighbours(bit(gate), device.agent).any(|(neighbour, other)| {
                choice.of(neighbour).is_some() && device.categories.overlaps(other.categories)
            });
        add(draws, device.agent, self.draw_of(device));
        let sum = draws.get(usize::from(device.agent)).copied().unwrap_or_default();
        let exceeds = agent.policy.supply.is_some() && sum > agent.supply;
        let unheld = device.is_safed_unless_held();
        if exceeds || conflicts || unheld {
            // It goes off, and leaves its room to the next orphan.
            if let Some(sum) = draws.get_mut(usize::from(device.agent)) {
                *sum = sum.saturating_sub(self.draw_of(device));
            }
        }
        exceeds || conflicts || unheld
    }

    fn grant_chosen(&mut self, candidates: &Candidates, choice: &Choice) {
        let mut owed = Draws::default();
        for seat in candidates {
            let Some(grant) = self.grant(*seat) else { continue };
            let gates = grant.gates;
            if grant.state != State::Waiting || !choice.has(*seat, gates) {
                continue;
            }
            if self.can_be_granted_now(gates, &owed) {
                self.start_granting(*seat);
            } else {
                let more = self.draws_of(gates, |device| device.phase == Phase::Off);
                for (sum, draw) in owed.iter_mut().zip(more) {
                    *sum = sum.saturating_add(draw);
                }
            }
        }
    }

    fn can_be_granted_now(&self, gates: u64, owed: &Draws) -> bool {
        let admissible =
            gates_of(gates).all(|gate| self.device(gate).is_some_and(DeviceBook::is_admissible));
        admissible && self.neighbours_are_clear(gates) && self.margin_suffices(gates, owed)
    }

    fn neighbours_are_clear(&self, gates: u64) -> bool {
        gates_of(gates).filter_map(|gate| self.device(gate)).all(|device| {
            let Some(policy) = self.agent(device.agent).map(|agent| agent.policy) else {
                return false;
            };
            self.neighbours(gates, device.agent).all(|(_, other)| {
                // A command that never comes back has had its deadline.
                let excluded = policy.exclusive && !other.is_quiescent() && !other.is_hung();
                let charged = other.phase != Phase::Off;
                let conflicts =
                    policy.categories && charged && device.categories.overlaps(other.categories);
                !excluded && !conflicts
            })
        })
    }

    fn margin_suffices(&self, gates: u64, owed: &Draws) -> bool {
        let more = self.draws_of(gates, |device| device.phase == Phase::Off);
        let charged = self.charges();
        self.agents.iter().enumerate().all(|(number, agent)| {
            let at = |draws: &Draws| draws.get(number).copied().unwrap_or_default();
            let sum = at(&charged).saturating_add(at(owed)).saturating_add(at(&more));
            agent.policy.supply.is_none() || at(&more).is_zero() || sum <= agent.supply
        })
    }

    /// What is charged now, for each agent.
    pub(super) fn charges(&self) -> Draws {
        let mut draws = Draws::default();
        for device in self.devices.iter().filter(|device| device.phase != Phase::Off) {
            add(&mut draws, device.agent, self.draw_of(device));
        }
        draws
    }

    /// From here its devices are charged to it, whatever becomes of the rest.
    fn start_granting(&mut self, seat: u16) {
        let broker = self.broker_seen.epoch;
        let Some(grant) = self.grant_mut(seat) else { return };
        grant.state = State::Granting;
        grant.broker_stamp = broker;
        grant.exempt = false;
        let (gates, ticket) = (grant.gates, grant.id(seat));
        for gate in gates_of(gates) {
            // Who gets back what it used last has used it all the time.
            if self.device(gate).is_some_and(|device| !device.last_user.is(ticket)) {
                self.settle_last_user(gate, self.now);
            }
            self.end_rest(gate);
            let agent = self.device(gate).and_then(|device| self.agent(device.agent));
            let stamp = agent.map_or(0, |agent| agent.seen.epoch);
            if let Some(device) = self.device_mut(gate) {
                device.phase = Phase::Admitting;
                device.tenant = Some(seat);
                device.agent_stamp = stamp;
                device.failed = 0;
                device.must_safe = false;
                device.needed_off = false;
                device.told_off = false;
                device.last_user = LastUser::from(ticket);
            }
        }
    }
}
