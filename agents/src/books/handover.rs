//! The hand-over: vacate, make safe, see off, admit. One small step at a time,
//! each named so that whoever finds it due may do it, and twice is once.

use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::{Estimate, Power};
use faregate_tickets::gate::{Blocked, Safed, Vacated};
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::standing::Stamp;
use faregate_tickets::validity::Validity;

use super::device::{DeviceBook, LastUser, Phase};
use super::grant::State;
use super::{Actions, Books, Noted, gates_of};

/// A step that is due at a gate.
#[expect(clippy::large_enum_variant, reason = "there is no heap to put the large one on")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Work {
    /// Put the tenant out, and wait until nothing is in progress.
    Vacate {
        /// The gate.
        gate: GateId,
        /// The tenure that ends.
        tenure: usize,
        /// How long a command may still take.
        timeout: Duration,
    },
    /// Issue the safing command.
    Safe {
        /// The gate.
        gate: GateId,
        /// The tenure in which nobody is admitted.
        tenure: usize,
        /// Which attempt this is, from 1.
        attempt: u8,
        /// How long a check or safing in progress may take.
        timeout: Duration,
    },
    /// Tell the gate that its device was seen off.
    SeenOff {
        /// The gate.
        gate: GateId,
        /// The present tenure.
        tenure: usize,
        /// When it was measured.
        at: Instant,
        /// How long a command in progress may take.
        timeout: Duration,
    },
    /// Make a ticket the tenant.
    Admit {
        /// The gate.
        gate: GateId,
        /// The tenure after which it follows.
        tenure: usize,
        /// The grant.
        ticket: TicketId,
        /// Its validity function for this gate.
        validity: Validity,
        /// The agent's epoch that was read before the decision.
        agent: usize,
        /// At the last of its gates: what makes the grant valid.
        stamp: Option<Stamp>,
        /// How long a check in progress may take.
        timeout: Duration,
    },
}

/// What became of a [`Work`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Done {
    /// The gate admits nobody.
    Vacated {
        /// The gate.
        gate: GateId,
        /// The tenure that ended.
        ended: usize,
        /// What the gate says.
        vacated: Vacated,
    },
    /// The safing command was issued.
    Safed {
        /// The gate.
        gate: GateId,
        /// The tenure.
        tenure: usize,
        /// Which attempt it was.
        attempt: u8,
        /// What the gate says.
        safed: Safed,
    },
    /// The gate knows that its device was seen off.
    SeenOff {
        /// The gate.
        gate: GateId,
        /// When it was measured.
        at: Instant,
    },
    /// The ticket is the tenant.
    Admitted {
        /// The gate.
        gate: GateId,
        /// The tenure after which it followed.
        after: usize,
        /// The new tenure.
        tenure: usize,
        /// The grant.
        ticket: TicketId,
    },
    /// The gate could not be entered, or had moved on.
    Blocked {
        /// The gate.
        gate: GateId,
        /// The tenure that was named.
        tenure: usize,
        /// Why.
        blocked: Blocked,
    },
}

impl Work {
    /// The gate concerned.
    #[must_use]
    pub fn gate(&self) -> GateId {
        match *self {
            Self::Vacate { gate, .. }
            | Self::Safe { gate, .. }
            | Self::SeenOff { gate, .. }
            | Self::Admit { gate, .. } => gate,
        }
    }
}

impl<const G: usize, const T: usize, const S: usize> Books<G, T, S> {
    /// The next step that is due, or when something may become due by itself.
    ///
    /// Steps come in the order of urgency: all gates of a round are vacated,
    /// then all its devices are made safe, then tickets are admitted. Within
    /// one kind, in the order of registration.
    ///
    /// # Errors
    /// When to come again, if nothing is due; never, if that is `None`.
    pub fn work(&self) -> Result<Work, Option<Instant>> {
        self.each(Self::vacating)
            .or_else(|| self.each(Self::safing))
            .or_else(|| self.each(Self::telling_empty))
            .or_else(|| self.each(Self::admitting))
            .or_else(|| self.each(Self::telling_held))
            .ok_or_else(|| self.due())
    }

    /// The next step that is due at one of these gates, in the same order.
    pub(crate) fn work_at(&self, gates: u64) -> Option<Work> {
        self.each_of(gates, Self::vacating)
            .or_else(|| self.each_of(gates, Self::safing))
            .or_else(|| self.each_of(gates, Self::telling_empty))
            .or_else(|| self.each_of(gates, Self::admitting))
            .or_else(|| self.each_of(gates, Self::telling_held))
    }

    fn each_of(
        &self,
        gates: u64,
        step: impl Fn(&Self, GateId, &DeviceBook) -> Option<Work>,
    ) -> Option<Work> {
        gates_of(gates).find_map(|gate| step(self, gate, self.device(gate)?))
    }

    fn each(&self, step: impl Fn(&Self, GateId, &DeviceBook) -> Option<Work>) -> Option<Work> {
        self.devices.iter().enumerate().find_map(|(number, device)| {
            let gate = u8::try_from(number).ok().map(GateId)?;
            step(self, gate, device)
        })
    }

    fn vacating(&self, gate: GateId, device: &DeviceBook) -> Option<Work> {
        let Phase::Leaving { hung, retry_at } = device.phase else { return None };
        if hung && self.now < retry_at {
            return None;
        }
        // Who has waited once in vain only looks whether it came back.
        let timeout = if hung { Duration::ZERO } else { device.profile.patience() };
        Some(Work::Vacate { gate, tenure: device.tenure, timeout })
    }

    fn safing(&self, gate: GateId, device: &DeviceBook) -> Option<Work> {
        let wanted = device.must_safe || device.needed_off;
        (device.phase == Phase::Idle && wanted && !device.stuck).then_some(Work::Safe {
            gate,
            tenure: device.tenure,
            attempt: device.attempts.wrapping_add(1),
            timeout: device.profile.patience(),
        })
    }

    fn telling_empty(&self, gate: GateId, device: &DeviceBook) -> Option<Work> {
        self.telling(gate, device).filter(|_| device.phase == Phase::Off)
    }

    /// Last of all: a command may be in progress there.
    fn telling_held(&self, gate: GateId, device: &DeviceBook) -> Option<Work> {
        self.telling(gate, device).filter(|_| device.phase == Phase::Held)
    }

    fn telling(&self, gate: GateId, device: &DeviceBook) -> Option<Work> {
        let at = device.tell_off?;
        Some(Work::SeenOff { gate, tenure: device.tenure, at, timeout: device.profile.patience() })
    }

    fn admitting(&self, gate: GateId, device: &DeviceBook) -> Option<Work> {
        if device.phase != Phase::Admitting {
            return None;
        }
        let seat = device.tenant?;
        let grant = self.grant(seat)?;
        let open = gates_of(grant.gates)
            .filter_map(|gate| self.device(gate))
            .filter(|device| device.phase == Phase::Admitting);
        let last = open.count() == 1;
        Some(Work::Admit {
            gate,
            tenure: device.tenure,
            ticket: grant.id(seat),
            validity: self.validity(seat, gate)?,
            agent: device.agent_stamp,
            stamp: last.then_some(Stamp { own: grant.own, broker: grant.broker_stamp }),
            timeout: device.profile.patience(),
        })
    }

    /// The validity function that a grant has for a gate.
    pub(super) fn validity(&self, seat: u16, gate: GateId) -> Option<Validity> {
        let grant = self.grant(seat)?;
        let Some(set) = grant.set else { return Some(grant.validity) };
        let members = &self.sets.get(usize::from(set))?.members;
        members.iter().find(|(member, _)| *member == gate).map(|(_, validity)| *validity)
    }

    fn due(&self) -> Option<Instant> {
        let times = self.devices.iter().filter_map(|device| match device.phase {
            // One unit later: at `until` itself the estimate may still come.
            Phase::Confirming { until } => Some(until.after(Duration::from_micros(1))),
            Phase::Leaving { hung: true, retry_at } => Some(retry_at),
            _ => None,
        });
        let over = self.more_is_over().then_some(self.now);
        times.chain(over).min()
    }

    pub(super) fn tick(&mut self, now: Instant, actions: &mut Actions<G>) {
        self.now = self.now.max(now);
        let now = self.now;
        for (number, device) in (0..).zip(&mut self.devices) {
            if matches!(device.phase, Phase::Confirming { until } if now > until) {
                device.attempt_failed(GateId(number), actions);
            }
        }
    }

    pub(super) fn observe(&mut self, gate: GateId, estimate: Estimate, actions: &mut Actions<G>) {
        if estimate.measured_at > self.now {
            // From a clock that is ahead: it would count as fresh for ever.
            return;
        }
        let Some(device) = self.device_mut(gate) else { return };
        if device.seen.is_some_and(|seen| seen.measured_at >= estimate.measured_at) {
            return;
        }
        device.seen = Some(estimate);
        #[cfg(not(feature = "mutant-stale-estimate"))]
        let fresh = estimate.measured_at > device.counts_from;
        #[cfg(feature = "mutant-stale-estimate")]
        let fresh = true;
        match (estimate.state, device.phase) {
            #[cfg(feature = "mutant-early-credit")]
            (Power::Off, Phase::Leaving { .. }) => self.seen_off(gate, estimate.measured_at),
            (Power::Off, Phase::Idle | Phase::Confirming { .. }) if fresh => {
                self.seen_off(gate, estimate.measured_at);
                actions.noted.push(Noted::SeenOff(gate));
            }
            (Power::Off, Phase::Admitting | Phase::Held) => {
                device.stuck &= !fresh;
                // Each time: it may have been on since the last measurement.
                device.tell_off = Some(estimate.measured_at);
            }
            // Not charged, so nobody waited for this; an interlock does.
            (Power::Off, Phase::Off) if fresh && !device.told_off => {
                device.tell_off = Some(estimate.measured_at);
                self.settle_last_user(gate, estimate.measured_at);
            }
            (Power::On, Phase::Confirming { .. }) if fresh => device.attempt_failed(gate, actions),
            // Something turned it on that is none of ours: it is orphaned.
            (Power::On, Phase::Off) if fresh && device.is_observable() => {
                device.phase = Phase::Idle;
                device.counts_from = estimate.measured_at;
                device.orphaned();
            }
            _ => {}
        }
    }

    /// The device draws nothing: its charge is credited, and who rested with it
    /// is back in line.
    fn seen_off(&mut self, gate: GateId, at: Instant) {
        self.settle_last_user(gate, at);
        let Some(device) = self.device_mut(gate) else { return };
        device.phase = Phase::Off;
        device.failed = 0;
        device.stuck = false;
        device.must_safe = false;
        device.needed_off = false;
        device.tell_off = Some(at);
        self.end_rest(gate);
    }

    /// Who rested until the device goes off need not wait any longer.
    pub(super) fn end_rest(&mut self, gate: GateId) {
        let user = self.device(gate).map(|device| &device.last_user);
        let Some(&LastUser::Grant { seat, .. }) = user else { return };
        if self.grant(seat).is_some_and(|grant| grant.state == State::Resting(gate)) {
            self.rejoin(seat);
        }
    }

    /// The integrals of whoever used the device last end here.
    pub(super) fn settle_last_user(&mut self, gate: GateId, at: Instant) {
        let Some(device) = self.device_mut(gate) else { return };
        let agent = device.agent;
        let user = device.last_user.clone();
        match user {
            LastUser::Nobody => {}
            LastUser::Grant { seat, serial } => {
                let alive = self.grant(seat).is_some_and(|grant| grant.serial == serial);
                if let Some(validity) = self.validity_mut(seat, gate).filter(|_| alive) {
                    validity.confirmed_off(at);
                }
            }
            LastUser::Gone { mut validity, .. } => {
                validity.confirmed_off(at);
                self.give_back(agent, &validity);
                if let Some(device) = self.device_mut(gate) {
                    device.last_user = LastUser::Nobody;
                }
            }
        }
    }

    pub(super) fn done(&mut self, done: Done, actions: &mut Actions<G>) {
        match done {
            Done::Vacated { gate, ended, vacated } => self.vacated(gate, ended, &vacated),
            Done::Safed { gate, tenure, attempt, safed } => {
                self.safed(gate, tenure, attempt, safed)
            }
            Done::SeenOff { gate, at } => {
                if let Some(device) =
                    self.device_mut(gate).filter(|device| device.tell_off == Some(at))
                {
                    device.tell_off = None;
                    device.told_off = device.phase == Phase::Off;
                }
            }
            Done::Admitted { gate, after, tenure, ticket } => {
                self.admitted(gate, after, tenure, ticket, actions);
            }
            Done::Blocked { gate, tenure, blocked } => self.blocked_at(gate, tenure, blocked),
        }
    }

    fn vacated(&mut self, gate: GateId, ended: usize, vacated: &Vacated) {
        let Some(device) = self.device_mut(gate) else { return };
        if !matches!(device.phase, Phase::Leaving { .. }) || device.tenure != ended {
            return;
        }
        device.tenure = vacated.tenure;
        device.attempts = 0;
        device.failed = 0;
        // Whoever used it may have freed it: it is worth trying again.
        device.stuck = false;
        device.phase = Phase::Idle;
        device.counts_from = vacated.at.after(device.profile.settling);
        // A user that was never admitted has its function as it was.
        match &mut device.last_user {
            LastUser::Gone { serial, validity } if *serial == vacated.latest_tenant => {
                *validity = vacated.validity;
                // A limit that ran out just before the ticket was given back
                // still ends with the device off.
                device.must_safe |= validity.ran_out(vacated.at).is_some();
            }
            LastUser::Grant { seat, serial } if *serial == vacated.latest_tenant => {
                let seat = *seat;
                if let Some(validity) = self.validity_mut(seat, gate) {
                    *validity = vacated.validity;
                }
            }
            _ => {}
        }
        self.skip_confirmation(gate, vacated);
    }

    /// A device that was seen off and has had no command to turn on since is
    /// off; one that is not charged need not be seen off.
    fn skip_confirmation(&mut self, gate: GateId, vacated: &Vacated) {
        let Some(device) = self.device(gate) else { return };
        let charged = self.is_charged(device) || device.must_safe || device.is_safed_unless_held();
        // Something else may have turned it on.
        let seen_on = device.seen.is_none_or(|seen| seen.state != Power::Off);
        if !(vacated.may_be_on || seen_on) {
            self.seen_off(gate, vacated.at);
        } else if !charged {
            self.leave_on(gate, vacated.at);
        }
    }

    /// Nobody waits for it to be seen off. Who used it and lives goes on using
    /// it until it is, or until somebody else has it.
    fn leave_on(&mut self, gate: GateId, at: Instant) {
        let gone = |device: &&DeviceBook| matches!(device.last_user, LastUser::Gone { .. });
        if self.device(gate).filter(gone).is_some() {
            self.settle_last_user(gate, at);
        }
        if let Some(device) = self.device_mut(gate) {
            device.settle_uncharged();
        }
    }

    fn safed(&mut self, gate: GateId, tenure: usize, attempt: u8, safed: Safed) {
        let Some(device) = self.device_mut(gate) else { return };
        let expected = device.attempts.wrapping_add(1) == attempt && device.tenure == tenure;
        if device.phase != Phase::Idle || !expected {
            return;
        }
        let at_rest = safed.at.after(device.profile.settling);
        device.attempts = attempt;
        device.counts_from = at_rest;
        device.phase = Phase::Confirming { until: at_rest.after(device.profile.estimate_lag) };
        if !device.is_observable() {
            self.seen_off(gate, safed.at);
        }
    }

    fn admitted(
        &mut self,
        gate: GateId,
        after: usize,
        tenure: usize,
        ticket: TicketId,
        actions: &mut Actions<G>,
    ) {
        let Some(device) = self.device_mut(gate) else { return };
        #[cfg(not(feature = "mutant-late-admission"))]
        let expected = device.phase == Phase::Admitting && device.tenant == Some(ticket.seat);
        #[cfg(feature = "mutant-late-admission")]
        let expected = true;
        if !expected || device.tenure != after {
            return;
        }
        device.phase = Phase::Held;
        device.tenure = tenure;
        let Some(gates) = self.grant_of(ticket).map(|grant| grant.gates) else { return };
        let held = |gate| self.device(gate).is_some_and(|device| device.phase == Phase::Held);
        if gates_of(gates).all(held) {
            if let Some(grant) = self.grant_mut(ticket.seat) {
                grant.state = State::Valid;
            }
            actions.granted.push(ticket);
        }
    }

    fn blocked_at(&mut self, gate: GateId, tenure: usize, blocked: Blocked) {
        let now = self.now;
        let Some(device) = self.device_mut(gate).filter(|device| device.tenure == tenure) else {
            return;
        };
        let retry_at = now.after(device.profile.patience());
        match (blocked, device.phase) {
            // Somebody else did it, and reports it.
            (Blocked::Stale, _) => device.tell_off = None,
            (_, Phase::Leaving { .. }) => device.phase = Phase::Leaving { hung: true, retry_at },
            (_, Phase::Idle) => device.stuck = true,
            _ => device.tell_off = None,
        }
    }
}
