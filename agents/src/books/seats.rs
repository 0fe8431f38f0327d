//! How grants come and go: requests, relinquishing, bars, limits that run out.

use faregate_tickets::amount::{Microjoules, Milligrams, Milliwatts};
use faregate_tickets::clock::Duration;
use faregate_tickets::id::{GateId, HolderId, Priority, TicketId};
use faregate_tickets::standing::Why;
use faregate_tickets::ticket::Holder;
use faregate_tickets::validity::{Function, Validity};

use crate::limits::{MAX_AGENTS, MAX_SET_GATES, SEATS_PER_KEPT};
use crate::refusal::{Capacity, RequestRefused};

use super::device::{LastUser, Phase};
use super::grant::{Grant, State};
use super::{Actions, Books, bit, gates_of};

/// What a request asks for: gates, all or nothing, each with its validity
/// function, at one priority.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Ask {
    priority: Priority,
    holder: HolderId,
    gates: heapless::Vec<(GateId, Validity), MAX_SET_GATES>,
}

impl Ask {
    /// One gate.
    #[must_use]
    pub fn new(priority: Priority, gate: GateId, validity: Validity) -> Self {
        let mut gates = heapless::Vec::new();
        // An empty vector has room for one.
        let _ = gates.push((gate, validity));
        Self { priority, holder: HolderId::UNNAMED, gates }
    }

    /// For this holder.
    #[must_use]
    pub fn held_by(mut self, holder: HolderId) -> Self {
        self.holder = holder;
        self
    }

    /// Who asks.
    #[must_use]
    pub fn holder(&self) -> HolderId {
        self.holder
    }

    /// And another.
    ///
    /// # Errors
    /// The gate twice, or too many gates.
    pub fn and(mut self, gate: GateId, validity: Validity) -> Result<Self, RequestRefused> {
        if self.gates.iter().any(|(other, _)| *other == gate) {
            return Err(RequestRefused::GateTwice(gate));
        }
        let full = RequestRefused::NoCapacity(Capacity::SetGates);
        self.gates.push((gate, validity)).map_err(|_| full)?;
        Ok(self)
    }

    fn bits(&self) -> u64 {
        self.gates.iter().fold(0, |bits, (gate, _)| bits | bit(*gate))
    }
}

/// What a request takes from one agent.
#[derive(Clone, Copy, Default)]
struct Taken {
    draw: Milliwatts,
    energy: Microjoules,
    propellant: Milligrams,
}

impl<const G: usize, const T: usize, const S: usize> Books<G, T, S> {
    /// Seats a request, or refuses what can never be; changes nothing then.
    pub(super) fn seat(&mut self, ask: &Ask) -> Result<TicketId, RequestRefused> {
        for (gate, validity) in &ask.gates {
            self.leased(*gate, validity)?;
        }
        let taken = self.agree_to(&ask.gates, 0)?;
        let full = RequestRefused::NoCapacity(Capacity::Seats);
        let seat = self.free_seat(ask.priority).ok_or(full)?;
        let set = self.set_for(&ask.gates)?;
        self.take(&taken);
        Ok(self.sit_down(seat, set, ask))
    }

    /// Adds a gate to a grant: all is given back, the union asked for, at the
    /// old arrival.
    ///
    /// # Errors
    /// [`RequestRefused`], and the books are as they were.
    pub fn extend(
        &mut self,
        ticket: TicketId,
        gate: GateId,
        validity: Validity,
        actions: &mut Actions<G>,
    ) -> Result<(), RequestRefused> {
        actions.clear();
        let grant = self.grant_of(ticket).ok_or(RequestRefused::Stale)?;
        let (bits, set) = (grant.gates, grant.set);
        if bits & bit(gate) != 0 {
            return Err(RequestRefused::GateTwice(gate));
        }
        let more = [(gate, self.leased(gate, &validity)?)];
        let taken = self.agree_to(&more, bits)?;
        let set = match set {
            Some(set) => set,
            None => self.free_set().ok_or(RequestRefused::NoCapacity(Capacity::Sets))?,
        };
        let members = self.sets.get(usize::from(set)).map_or(0, |book| book.members.len());
        if members.max(1) + more.len() > MAX_SET_GATES {
            return Err(RequestRefused::NoCapacity(Capacity::SetGates));
        }
        self.take(&taken);
        self.grow(ticket.seat, set, &more, actions);
        Ok(())
    }

    /// The validity function of a ticket for this gate: one for a device with
    /// draw has a lease. Made where it stays: what is asked for is not copied
    /// as a whole.
    fn leased(&self, gate: GateId, validity: &Validity) -> Result<Validity, RequestRefused> {
        let device = self.device(gate).ok_or(RequestRefused::UnknownGate)?;
        let lease = device.profile.lease;
        if device.profile.draw.is_zero() || lease == Duration::MAX || validity.lease().is_some() {
            return Ok(*validity);
        }
        let full = RequestRefused::NoCapacity(Capacity::ValidityFunctions);
        validity.and(Function::lease(lease)).map_err(|_| full)
    }

    /// Whether each agent could ever grant this beside the `others` that the
    /// grant has already, and has the budgets now.
    fn agree_to(
        &self,
        gates: &[(GateId, Validity)],
        others: u64,
    ) -> Result<[Taken; MAX_AGENTS], RequestRefused> {
        let mut taken = [Taken::default(); MAX_AGENTS];
        for gate in gates_of(others) {
            self.add_draw(&mut taken, gate)?;
        }
        for (gate, validity) in gates {
            let sum = self.add_draw(&mut taken, *gate)?;
            sum.energy = sum.energy.saturating_add(validity.energy_left());
            sum.propellant = sum.propellant.saturating_add(validity.propellant_left());
        }
        for (agent, sum) in self.agents.iter().zip(&taken) {
            agent.agrees_to(sum)?;
        }
        Ok(taken)
    }

    fn add_draw<'a>(
        &self,
        taken: &'a mut [Taken; MAX_AGENTS],
        gate: GateId,
    ) -> Result<&'a mut Taken, RequestRefused> {
        let device = self.device(gate).ok_or(RequestRefused::UnknownGate)?;
        let sum = taken.get_mut(usize::from(device.agent)).ok_or(RequestRefused::UnknownGate)?;
        sum.draw = sum.draw.saturating_add(device.profile.draw);
        Ok(sum)
    }

    fn take(&mut self, taken: &[Taken; MAX_AGENTS]) {
        for (agent, sum) in self.agents.iter_mut().zip(taken) {
            agent.energy_left = agent.energy_left.saturating_sub(sum.energy);
            agent.propellant_left = agent.propellant_left.saturating_sub(sum.propellant);
        }
    }

    fn free_seat(&self, priority: Priority) -> Option<u16> {
        let urgent = !Priority::FAULT_RESPONSE.is_more_important_than(priority);
        let kept = if urgent { 0 } else { T / SEATS_PER_KEPT };
        let room = usize::from(self.seated) + kept < T;
        self.grants.get(usize::from(self.free)).filter(|_| room).map(|_| self.free)
    }

    fn free_set(&self) -> Option<u8> {
        let free = self.sets.iter().position(|set| set.seat.is_none())?;
        u8::try_from(free).ok()
    }

    fn set_for(&self, gates: &[(GateId, Validity)]) -> Result<Option<u8>, RequestRefused> {
        if gates.len() <= 1 {
            return Ok(None);
        }
        let full = RequestRefused::NoCapacity(Capacity::Sets);
        self.free_set().map(Some).ok_or(full)
    }

    /// Whether each gate's ticket can have its lease was asked before.
    fn sit_down(&mut self, seat: u16, set: Option<u8>, ask: &Ask) -> TicketId {
        let validity = ask.gates.first().map_or(Validity::always(), |(gate, validity)| {
            self.leased(*gate, validity).unwrap_or(*validity)
        });
        let (serial, arrival) = (self.next_serial, self.next_arrival);
        self.next_serial = self.next_serial.wrapping_add(1).max(1);
        self.next_arrival += 1;
        if let Some(grant) = self.grants.get_mut(usize::from(seat)) {
            self.free = grant.next_free;
            self.seated += 1;
            *grant = Grant {
                serial,
                gates: ask.bits(),
                priority: ask.priority,
                arrival,
                own: grant.own,
                validity,
                set,
                ..Grant::free(usize::from(seat))
            };
        }
        if let Some(set) = set {
            self.fill_set(set, seat, ask);
        }
        self.stand_in_line(seat);
        TicketId { seat, serial }
    }

    fn fill_set(&mut self, set: u8, seat: u16, ask: &Ask) {
        for (gate, validity) in &ask.gates {
            let validity = self.leased(*gate, validity).unwrap_or(*validity);
            let Some(book) = self.sets.get_mut(usize::from(set)) else { return };
            book.seat = Some(seat);
            // As many as there may be in a set, in both.
            let _ = book.members.push((*gate, validity));
        }
    }

    fn grow(&mut self, seat: u16, set: u8, more: &[(GateId, Validity)], actions: &mut Actions<G>) {
        self.leave_line(seat);
        self.preempt(seat, Why::Extended, actions);
        let first = self.grant(seat).map(|grant| (grant.set, grant.gates, grant.validity));
        if let Some(book) = self.sets.get_mut(usize::from(set)) {
            book.seat = Some(seat);
            if let Some((None, bits, validity)) = first {
                book.members.clear();
                for gate in gates_of(bits) {
                    let _ = book.members.push((gate, validity));
                }
            }
            for member in more {
                // Room was made sure of before anything changed.
                let _ = book.members.push(*member);
            }
        }
        if let Some(grant) = self.grant_mut(seat) {
            grant.set = Some(set);
            grant.gates = more.iter().fold(grant.gates, |bits, (gate, _)| bits | bit(*gate));
        }
        self.arbitrate(actions);
    }

    /// Grants of one gate stand in its roster; sets are in their own table.
    pub(super) fn stand_in_line(&mut self, seat: u16) {
        let Some(grant) = self.grant(seat) else { return };
        if let (None, Some(gate)) = (grant.set, gates_of(grant.gates).next()) {
            let priority = grant.priority;
            self.rosters.join(usize::from(gate.0), priority, seat);
        }
    }

    /// Takes an eligible grant out of its roster.
    pub(super) fn leave_line(&mut self, seat: u16) {
        let Some(grant) = self.grant(seat).filter(|grant| grant.is_eligible()) else { return };
        if let (None, Some(gate)) = (grant.set, gates_of(grant.gates).next()) {
            let priority = grant.priority;
            self.rosters.leave(usize::from(gate.0), priority, seat);
        }
    }

    /// The validity function that a grant has for a gate.
    pub(super) fn validity_mut(&mut self, seat: u16, gate: GateId) -> Option<&mut Validity> {
        let set = self.grant(seat)?.set;
        let Some(set) = set else { return self.grant_mut(seat).map(|grant| &mut grant.validity) };
        let members = &mut self.sets.get_mut(usize::from(set))?.members;
        members.iter_mut().find(|(member, _)| *member == gate).map(|(_, validity)| validity)
    }

    pub(super) fn relinquish(
        &mut self,
        ticket: TicketId,
        gate: GateId,
        holder: Holder,
        actions: &mut Actions<G>,
    ) {
        let Some(grant) = self.grant_of(ticket).filter(|grant| grant.gates & bit(gate) != 0) else {
            return;
        };
        let only = grant.gates == bit(gate);
        if let Some(device) = self.device_mut(gate).filter(|device| device.last_user.is(ticket)) {
            device.must_safe |= holder == Holder::Died && device.phase != Phase::Off;
        }
        if only {
            self.end(ticket.seat, actions);
        } else {
            self.give_up_gate(ticket.seat, gate, actions);
        }
    }

    /// One gate of a set is given back; the others stay valid.
    fn give_up_gate(&mut self, seat: u16, gate: GateId, actions: &mut Actions<G>) {
        let state = self.grant(seat).map(|grant| grant.state);
        if state == Some(State::Granting) {
            // The gate might be the last one, which would make the rest valid.
            self.preempt(seat, Why::NotYetGranted, actions);
        }
        self.orphan(seat, gate);
        let set = self.grant(seat).and_then(|grant| grant.set);
        if let Some(book) = set.and_then(|set| self.sets.get_mut(usize::from(set))) {
            book.members.retain(|(member, _)| *member != gate);
        }
        if let Some(grant) = self.grant_mut(seat) {
            grant.gates &= !bit(gate);
        }
        if state == Some(State::Resting(gate)) {
            self.rejoin(seat);
        }
    }

    /// A grant is over: its seat is free at once, its devices are not.
    pub(super) fn end(&mut self, seat: u16, actions: &mut Actions<G>) {
        let Some(grant) = self.grant(seat) else { return };
        let (gates, set, id) = (grant.gates, grant.set, grant.id(seat));
        self.leave_line(seat);
        for gate in gates_of(gates) {
            self.orphan(seat, gate);
        }
        if let Some(book) = set.and_then(|set| self.sets.get_mut(usize::from(set))) {
            book.seat = None;
            book.members.clear();
        }
        actions.ended.push(id);
        let free = self.free;
        if let Some(grant) = self.grants.get_mut(usize::from(seat)) {
            let own = grant.own.wrapping_add(1);
            *grant = Grant { own, next_free: free, ..Grant::free(usize::from(seat)) };
            self.free = seat;
            self.seated = self.seated.saturating_sub(1);
        }
    }

    /// A waiting grant whose time is over ends when its turn comes, before
    /// anybody is taken for it. As many as the actions have room for; the rest
    /// is for the next step.
    pub(super) fn end_what_is_over(&mut self, actions: &mut Actions<G>) {
        for gate in 0..self.devices.len() {
            while let Some(seat) = self.first_in_line(gate).filter(|seat| self.is_over(*seat)) {
                if actions.ended.len() >= G {
                    return;
                }
                self.end(seat, actions);
            }
        }
        for set in 0..S {
            let seat = self.sets.get(set).and_then(|set| set.seat);
            if actions.ended.len() >= G {
                return;
            }
            if let Some(seat) = seat.filter(|seat| self.is_over(*seat)) {
                self.end(seat, actions);
            }
        }
    }

    /// Whether there was more to end than one step can.
    pub(super) fn more_is_over(&self) -> bool {
        let mut lines = (0..self.devices.len()).filter_map(|gate| self.first_in_line(gate));
        let mut sets = self.sets.iter().filter_map(|set| set.seat);
        lines.any(|seat| self.is_over(seat)) || sets.any(|seat| self.is_over(seat))
    }

    fn first_in_line(&self, gate: usize) -> Option<u16> {
        self.rosters.first(gate).and_then(|seat| u16::try_from(seat).ok())
    }

    pub(super) fn is_over(&self, seat: u16) -> bool {
        let Some(grant) = self.grant(seat).filter(|grant| grant.state == State::Waiting) else {
            return false;
        };
        gates_of(grant.gates)
            .filter_map(|gate| self.validity(seat, gate))
            .any(|validity| validity.has_ended(self.now))
    }

    /// The device loses the grant that uses it, or used it last. What that
    /// grant left of its budgets goes back when the device is seen off.
    fn orphan(&mut self, seat: u16, gate: GateId) {
        let Some(serial) = self.grant(seat).map(|grant| grant.serial) else { return };
        let validity = self.validity_mut(seat, gate).map(|validity| *validity);
        let Some(device) = self.device_mut(gate) else { return };
        let held = device.tenant == Some(seat);
        if held {
            device.leave();
        }
        let used = device.last_user.is(TicketId { seat, serial });
        let off = device.phase == Phase::Off;
        if used && !off {
            device.orphaned();
        }
        let Some(validity) = validity else { return };
        if held || (used && !off) {
            // While its gate has not been vacated, the gate has the newer one.
            device.last_user = LastUser::Gone { serial, validity };
            return;
        }
        if used {
            device.last_user = LastUser::Nobody;
        }
        let agent = device.agent;
        self.give_back(agent, &validity);
    }

    /// Unused budget goes back to its agent.
    pub(super) fn give_back(&mut self, agent: u8, validity: &Validity) {
        let Some(agent) = self.agents.get_mut(usize::from(agent)) else { return };
        if agent.policy.energy.is_some() {
            agent.energy_left = agent.energy_left.saturating_add(validity.energy_left());
        }
        if agent.policy.propellant.is_some() {
            agent.propellant_left =
                agent.propellant_left.saturating_add(validity.propellant_left());
        }
    }

    /// Revokes a grant that stays in line.
    pub(super) fn preempt(&mut self, seat: u16, why: Why, actions: &mut Actions<G>) {
        let Some(grant) = self.grant_mut(seat).filter(|grant| grant.is_granted()) else { return };
        grant.state = State::Waiting;
        grant.exempt = false;
        grant.own = grant.own.wrapping_add(1);
        let (gates, id) = (grant.gates, grant.id(seat));
        actions.revoked.push((id, why));
        self.put_out(seat, gates);
    }

    /// The gates of a grant that is not valid any more are to be vacated.
    pub(super) fn put_out(&mut self, seat: u16, gates: u64) {
        for gate in gates_of(gates) {
            if let Some(device) = self.device_mut(gate).filter(|device| device.tenant == Some(seat))
            {
                device.leave();
            }
        }
    }

    pub(super) fn bar(&mut self, seat: u16, epoch: usize, actions: &mut Actions<G>) {
        let Some(grant) = self.grant(seat) else { return };
        let (gates, ticket) = (grant.gates, grant.id(seat));
        self.leave_line(seat);
        self.put_out(seat, gates);
        for gate in gates_of(gates) {
            let device = self.device_mut(gate);
            if let Some(device) = device.filter(|device| device.last_user.is(ticket)) {
                device.must_safe |= device.phase != Phase::Off;
            }
        }
        if let Some(grant) = self.grant_mut(seat) {
            grant.state = State::Barred;
            grant.exempt = false;
            grant.own = epoch;
            actions.explained.push((grant.id(seat), Why::Barred));
        }
    }

    /// Somebody meant an earlier grant of this seat: the one that was hit waits,
    /// and is restored in its turn.
    pub(super) fn hit_by_stale_bar(&mut self, seat: u16, epoch: usize, actions: &mut Actions<G>) {
        let Some(grant) = self.grants.get_mut(usize::from(seat)) else { return };
        grant.own = epoch;
        if grant.serial != 0 && grant.is_granted() {
            grant.state = State::Waiting;
            grant.exempt = false;
            let (gates, id) = (grant.gates, grant.id(seat));
            // Nothing that could be said of somebody else's bar is true of it.
            actions.explained.push((id, Why::Unknown));
            self.put_out(seat, gates);
        }
    }

    pub(super) fn reinstate(&mut self, ticket: TicketId) {
        let barred = self.grant_of(ticket).is_some_and(|grant| grant.state == State::Barred);
        if barred {
            self.rejoin(ticket.seat);
        }
    }

    /// Back in line, behind those who came meanwhile.
    pub(super) fn rejoin(&mut self, seat: u16) {
        let arrival = self.next_arrival;
        if let Some(grant) = self.grant_mut(seat) {
            grant.state = State::Waiting;
            grant.arrival = arrival;
            self.next_arrival += 1;
        }
        self.stand_in_line(seat);
    }

    pub(super) fn run_out(
        &mut self,
        gate: GateId,
        serial: usize,
        ends_ticket: bool,
        actions: &mut Actions<G>,
    ) {
        let Some(seat) = self.device(gate).and_then(|device| device.tenant) else { return };
        if self.grant(seat).is_none_or(|grant| grant.serial != serial) {
            return;
        }
        if let Some(device) = self.device_mut(gate) {
            device.must_safe = true;
        }
        if ends_ticket {
            self.end(seat, actions);
            return;
        }
        self.leave_line(seat);
        self.preempt(seat, Why::Resting, actions);
        if let Some(grant) = self.grant_mut(seat) {
            grant.state = State::Resting(gate);
        }
    }
}

impl super::AgentBook {
    fn agrees_to(&self, taken: &Taken) -> Result<(), RequestRefused> {
        let Taken { draw, energy, propellant } = *taken;
        if self.policy.supply.is_some() && draw > self.largest_supply {
            return Err(RequestRefused::OverSupply { draw, supply: self.largest_supply });
        }
        if self.policy.energy.is_some() && energy > self.energy_left {
            return Err(RequestRefused::NoEnergy { asked: energy, left: self.energy_left });
        }
        if self.policy.propellant.is_some() && propellant > self.propellant_left {
            let left = self.propellant_left;
            return Err(RequestRefused::NoPropellant { asked: propellant, left });
        }
        Ok(())
    }
}
