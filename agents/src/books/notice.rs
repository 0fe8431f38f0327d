//! What the books learn from outside: epochs, faults, supplies.

use faregate_tickets::amount::Milliwatts;
use faregate_tickets::fault::GateFault;
use faregate_tickets::id::GateId;
use faregate_tickets::scope::Seen;
use faregate_tickets::standing::Why;

use crate::limits::{LARGEST_SUPPLY, MAX_AGENTS, MAX_GATES};

use super::device::Phase;
use super::{Actions, Books, Noted, bit};

impl<const G: usize, const T: usize, const S: usize> Books<G, T, S> {
    /// Everything granted under an epoch that has ended is revoked; all devices
    /// of that scope are made safe, in the order of registration.
    pub(super) fn notice(
        &mut self,
        broker: Seen,
        agents: &[Seen; MAX_AGENTS],
        survivors: u64,
        actions: &mut Actions<G>,
    ) {
        let broker_ended = self.broker_seen.epoch != broker.epoch;
        self.broker_seen = broker;
        for number in 0..self.devices.len() {
            let Ok(gate) = u8::try_from(number).map(GateId) else { continue };
            let Some(agent) = self.device(gate).map(|device| device.agent) else { continue };
            let seen = agents.get(usize::from(agent)).copied().unwrap_or_default();
            let ended =
                broker_ended || self.agent(agent).is_some_and(|book| book.seen.epoch != seen.epoch);
            self.notice_tenant(gate, broker.epoch, seen.epoch, survivors, actions);
            if let Some(device) = self.device_mut(gate).filter(|_| ended) {
                device.must_safe |=
                    !matches!(device.phase, Phase::Off | Phase::Held | Phase::Admitting);
            }
        }
        for (book, seen) in self.agents.iter_mut().zip(agents) {
            book.seen = *seen;
        }
    }

    /// The scopes whose epoch has ended since the books last heard of them.
    pub(crate) fn ended<'a>(
        &'a self,
        broker: Seen,
        agents: &'a [Seen; MAX_AGENTS],
    ) -> impl Iterator<Item = Seen> + 'a {
        let heard = self.agents.iter().map(|agent| agent.seen);
        let scopes = core::iter::once((self.broker_seen, broker));
        let scopes = scopes.chain(heard.zip(agents.iter().copied()));
        scopes.filter(|(heard, seen)| heard.epoch != seen.epoch).map(|(_, seen)| seen)
    }

    fn notice_tenant(
        &mut self,
        gate: GateId,
        broker: usize,
        agent: usize,
        survivors: u64,
        actions: &mut Actions<G>,
    ) {
        let Some(device) = self.device(gate) else { return };
        let Some(seat) = device.tenant else { return };
        let agent_ended = device.agent_stamp != agent;
        let Some(grant) = self.grant_mut(seat) else { return };
        let broker_ended = grant.broker_stamp != broker;
        // Exempt also while the epoch that it announced is not there yet: the
        // floor is.
        if !agent_ended && survivors & bit(gate) != 0 {
            grant.exempt = true;
            grant.broker_stamp = broker;
            return;
        }
        if agent_ended || broker_ended {
            // Its own epoch ends too: what is left of its stamps must not make
            // one gate of a set valid before the others.
            self.preempt(seat, Why::RevokedAll, actions);
        }
    }

    pub(super) fn notice_faults(
        &mut self,
        faults: &[Option<GateFault>; MAX_GATES],
        actions: &mut Actions<G>,
    ) {
        for ((number, device), fault) in (0..).zip(&mut self.devices).zip(faults) {
            if let (None, Some(fault)) = (device.fault, *fault) {
                // What the driver did last is not known.
                device.must_safe |= device.phase != Phase::Off;
                actions.noted.push(Noted::Faulted(GateId(number), fault));
            }
            device.fault = *fault;
        }
    }

    /// The gate takes tickets again; its device is orphaned.
    pub(super) fn reset(&mut self, gate: GateId) {
        if let Some(device) = self.device_mut(gate) {
            device.fault = None;
            device.failed = 0;
            device.stuck = false;
            if device.tenant.is_none() && device.phase != Phase::Off {
                device.orphaned();
            }
        }
    }

    pub(super) fn set_supply(&mut self, agent: u8, supply: Milliwatts) {
        if let Some(book) = self.agents.get_mut(usize::from(agent)) {
            let supply = supply.min(LARGEST_SUPPLY);
            book.supply = supply;
            book.largest_supply = book.largest_supply.max(supply);
        }
    }
}
