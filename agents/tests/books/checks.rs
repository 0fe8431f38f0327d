//! What holds after every step, and when nothing is in motion.

use std::sync::atomic::Ordering::Relaxed;

use faregate_agents::DeviceState;
use faregate_tickets::amount::Microjoules;
use faregate_tickets::clock::Duration;
use faregate_tickets::id::GateId;

use super::lamp::Switch;
use super::step::Step;
use super::world::{ENERGY, Granted, SEATS, World};

/// The sensors' period: shorter than any device's estimate lag.
const ROUND: Duration = Duration::from_millis(4);
const MOST_ROUNDS: usize = 200;
/// Together longer than any device takes to settle.
const QUIET_ROUNDS: usize = 3;

impl World<'_> {
    /// After every step of a history.
    pub(crate) fn check(&self) {
        self.check_truth_is_charged();
        self.check_standings();
        self.check_tickets();
        self.check_valid_together();
        assert_eq!(self.books.free_seats(), SEATS - self.grants.len(), "seats are free at once");
    }

    /// **Margin Kept.** Nothing is added to the charges beyond the supply.
    /// (What was charged at boot, or before the supply fell, or what something
    /// else turned on, stays until it is seen off.)
    pub(crate) fn check_charges(&mut self) {
        let charged = self.charges();
        self.charged_before = std::mem::replace(&mut self.charged, charged);
        if std::mem::take(&mut self.unbidden_seen) {
            self.charged_before.clone_from(&self.charged);
        }
        let before = &self.charged_before;
        for (agent, (before, after)) in before.iter().zip(&self.charged).enumerate() {
            let within = *after <= (*before).max(self.supply[agent]);
            let rules = self.rules(agent);
            assert!(rules.supply.is_none() || within, "Margin Kept: {before} grew to {after}");
        }
    }

    /// **Margin Kept.** What draws is charged, unless something else turned it
    /// on and no sensor has said so.
    fn check_truth_is_charged(&self) {
        for gate in self.gate_ids() {
            let truth = &self.ground.truths[usize::from(gate.0)];
            let device = self.declared(usize::from(gate.0));
            let counts = self.rules(usize::from(device.agent)).supply.is_some() && device.draw > 0;
            let draws = truth.draws(self.now()) && !truth.unbidden.load(Relaxed);
            let charge = self.books.device_report(gate).unwrap().charge.get();
            assert!(!(counts && draws) || charge > 0, "Margin Kept: {gate} draws uncharged");
        }
    }

    /// The books count each grant's own epoch as its standing does.
    fn check_standings(&self) {
        if self.ground.broker.has_bars() {
            return;
        }
        for seat in 0..u16::try_from(SEATS).unwrap() {
            let (serial, own) = self.books.counted(seat).unwrap();
            assert_eq!(self.standing(seat).epoch_seen(), own, "the own epoch is counted");
            assert!(self.standing(seat).is_occupied_by(serial));
        }
    }

    /// What the books have down as valid is valid, all of it; nothing else is.
    fn check_tickets(&self) {
        if !self.is_noticed() || !self.unreported.is_empty() || !self.faults_are_noticed() {
            return;
        }
        for grant in self.grants.values() {
            let valid = self.books.is_valid(grant.id);
            for (gate, ticket) in &grant.tickets {
                assert_eq!(ticket.check().is_ok(), valid, "{} at {gate}", grant.id);
            }
        }
    }

    fn faults_are_noticed(&self) -> bool {
        self.keys.iter().zip(&self.faults).all(|(key, seen)| key.fault().is_some() == *seen)
    }

    /// No two grants are valid together against their agent's policy.
    fn check_valid_together(&self) {
        let valid: Vec<_> = self
            .grants
            .values()
            .filter(|grant| grant.tickets.iter().any(|(_, ticket)| ticket.check().is_ok()))
            .collect();
        for (n, one) in valid.iter().enumerate() {
            for other in &valid[n + 1..] {
                for (a, b) in one.gates().flat_map(|a| other.gates().map(move |b| (a, b))) {
                    self.check_pair(a, b);
                }
            }
        }
    }

    /// What was granted in the latest step was clear of others, and of what
    /// more important ones are owed.
    pub(crate) fn check_granted(&mut self) {
        let report = |gate| self.books.device_report(gate).unwrap().tenant;
        let tenants: Vec<_> = self.gate_ids().map(report).collect();
        let before = std::mem::replace(&mut self.tenants, tenants);
        for (gate, old) in before.into_iter().enumerate() {
            let new = self.tenants[gate].filter(|new| Some(*new) != old);
            if let Some(grant) = new.and_then(|new| self.grants.get(&new.serial)) {
                self.check_clear(gate, grant);
                self.check_owed(gate, grant);
            }
        }
    }

    /// **Empty Room.** At an exclusive agent nobody is granted anything while a
    /// command of another may be in progress, unless that one's time is over;
    /// and nobody what conflicts with a device that may be on.
    fn check_clear(&self, mine: usize, grant: &Granted<'_>) {
        let rules = self.rules(usize::from(self.declared(mine).agent));
        for gate in (0..self.stuck.len()).filter(|gate| grant.gates().all(|it| it != *gate)) {
            let (one, other) = (self.declared(mine), self.declared(gate));
            let state = self.state(gate);
            let near = one.agent == other.agent;
            let leaving = near && rules.exclusive && state == DeviceState::Leaving;
            assert!(!leaving, "Empty Room: gate {gate}, granted {}", grant.id);
            let conflict = one.categories & other.categories != 0 && state != DeviceState::Off;
            assert!(!(near && rules.categories && conflict), "gate {gate} conflicts with {mine}");
        }
    }

    /// What is owed to more important ones is not granted to others meanwhile.
    fn check_owed(&self, gate: usize, grant: &Granted<'_>) {
        let agent = self.declared(gate).agent;
        let rank = |it: &Granted<'_>| (u8::MAX - it.priority, it.arrival);
        let chosen = self.chosen();
        let owed = self.grants.values().filter(|other| {
            let waits = other.gates().all(|gate| self.tenants[gate] != Some(other.id));
            chosen.contains(&other.id.serial) && waits && rank(other) < rank(grant)
        });
        let off = |gate: &usize| self.state(*gate) == DeviceState::Off;
        let mine = |gate: &usize| self.declared(*gate).agent == agent;
        let gates = owed.flat_map(Granted::gates).filter(mine).filter(off);
        let owed: u64 = gates.map(|gate| self.declared(gate).draw).sum();
        let charged = self.charged[usize::from(agent)];
        let supply = self.rules(usize::from(agent)).supply.map(|_| self.supply[usize::from(agent)]);
        let grew = charged > self.charged_before[usize::from(agent)];
        let within = supply.is_none_or(|supply| charged + owed <= supply);
        assert!(!grew || within, "{owed} of {charged} is owed, and {} is granted", grant.id);
    }

    fn check_pair(&self, a: usize, b: usize) {
        assert_ne!(a, b, "One Tenant");
        let (one, other) = (self.declared(a), self.declared(b));
        if one.agent != other.agent {
            return;
        }
        let rules = self.rules(usize::from(one.agent));
        assert!(!rules.exclusive, "two are valid at an exclusive agent");
        let conflict = one.categories & other.categories != 0;
        assert!(!rules.categories || !conflict, "gates {a} and {b} share a category");
    }

    /// Everything that can be healed is, and time passes until nothing moves.
    pub(crate) fn heal_and_settle(&mut self) {
        for truth in &self.ground.truths {
            truth.deaf_to_safing.store(0, Relaxed);
            truth.hung.store(false, Relaxed);
        }
        while let Some(done) = self.unreported.pop() {
            self.report(done);
        }
        self.late_estimates.clear();
        for gate in self.gate_ids() {
            if self.keys[usize::from(gate.0)].fault().is_some() {
                self.apply(&Step::Reset { gate: gate.0 });
            }
        }
        self.settle();
    }

    /// Rounds of sensors and service, until several change nothing.
    pub(crate) fn settle(&mut self) {
        let mut quiet = 0;
        for _ in 0..MOST_ROUNDS {
            let before = self.changes;
            self.service();
            self.ground.clock.advance(ROUND);
            for gate in self.gate_ids() {
                self.observe(gate, self.measure(gate));
            }
            for (_, ticket) in self.grants.values().flat_map(|grant| &grant.tickets) {
                let _ = ticket.renew();
            }
            self.service();
            self.check();
            let moves = self.changes != before || self.is_in_motion();
            quiet = if moves { 0 } else { quiet + 1 };
            if quiet == QUIET_ROUNDS {
                return;
            }
        }
        panic!("the world does not come to rest: {:?}", self.books.work());
    }

    fn is_in_motion(&self) -> bool {
        let moves = |state| matches!(state, DeviceState::Leaving | DeviceState::Confirming);
        let device = |gate| self.books.device_report(gate).unwrap();
        self.gate_ids().any(|gate| moves(device(gate).state))
    }

    /// **Highest First** and **Restoration**: when nothing is in motion, those
    /// are valid whom the oracle would choose.
    pub(crate) fn check_chosen(&self) {
        let chosen = self.chosen();
        for (serial, grant) in &self.grants {
            let valid = self.books.is_valid(grant.id);
            let waiting = self.books.waiting_for(grant.id);
            let named = chosen.contains(serial);
            assert_eq!(valid, named, "Highest First: {} waits for {waiting:?}", grant.id);
        }
        for gate in self.gate_ids() {
            let declared = self.declared(usize::from(gate.0));
            let unheld = declared.safe_unless_held;
            let orphaned = self.state(usize::from(gate.0)) == DeviceState::Orphaned;
            assert!(!(unheld && orphaned), "{gate} is nobody's, and not made safe");
            let report = self.books.device_report(gate).unwrap();
            let truth = &self.ground.truths[usize::from(gate.0)];
            // What nobody looks at may have been deaf.
            let unseen = declared.draw == 0 && declared.categories == 0;
            let may_draw = report.tenant.is_some()
                || report.state == DeviceState::Stuck
                || unseen
                || truth.unbidden.load(Relaxed);
            let draws = truth.draws(self.now());
            assert!(!(unheld && draws) || may_draw, "{gate} is nobody's, and on");
        }
    }

    /// **Source Death.** Nothing that is to be made safe when it is orphaned is
    /// left as it is.
    pub(crate) fn check_orphans(&self) {
        for gate in self.gate_ids() {
            let number = usize::from(gate.0);
            let held = self.grants.values().any(|grant| grant.gates().any(|it| it == number));
            let orphaned = self.books.device_report(gate).unwrap().state == DeviceState::Orphaned;
            let declared = self.declared(number);
            let safe_at_once = declared.safe_at_once && !declared.safe_unless_held;
            assert!(held || !orphaned || !safe_at_once, "{gate} is an orphan, and not made safe");
        }
    }

    /// Everybody goes home: nothing is charged, taken, or lost.
    pub(crate) fn go_home(&mut self) {
        self.ground.broker.leave_safe_mode();
        for scope in &self.ground.scopes {
            scope.leave_safe_mode();
        }
        for grant in self.grants.values() {
            for (_, ticket) in &grant.tickets {
                let _ = ticket.invoke(Switch::Off);
            }
        }
        while let Some(serial) = self.pick(0) {
            self.relinquish(serial, 0);
        }
        self.settle();
        self.check_orphans();
        for (agent, charge) in self.charges().iter().enumerate() {
            // An orphan may stay on until somebody needs what it draws.
            let draws = |gate: &GateId| self.ground.truths[usize::from(gate.0)].draws(self.now());
            let of_agent =
                |gate: &GateId| usize::from(self.declared(usize::from(gate.0)).agent) == agent;
            let kept: Vec<_> = self.gate_ids().filter(of_agent).filter(draws).collect();
            let draw = kept.iter().map(|gate| self.declared(usize::from(gate.0)).draw).sum();
            let counts = self.rules(agent).supply.is_some();
            assert_eq!(*charge, if counts { draw } else { 0 }, "Margin Kept: back to the unit");
            if kept.is_empty() {
                self.check_budget(agent);
            }
        }
        assert_eq!(self.books.free_seats(), SEATS);
    }

    fn check_budget(&self, agent: usize) {
        let total = if self.rules(agent).energy { ENERGY } else { Microjoules::ZERO };
        let left = self.books.budgets(u8::try_from(agent).unwrap()).unwrap().0;
        let back = left == total || (self.budget_used && left < total);
        assert!(back, "an unused budget is back to the unit: {left} of {total}");
    }
}
