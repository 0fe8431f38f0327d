//! Who ought to have what: by trying each ticket beside all more important
//! ones, knowing nothing of rosters, phases and victims.

use faregate_agents::DeviceState;
use faregate_tickets::id::GateId;

use super::world::{Granted, World};

impl World<'_> {
    /// The serials of those who ought to be valid when nothing is in motion.
    pub(crate) fn chosen(&self) -> Vec<usize> {
        let mut order: Vec<&Granted<'_>> = self.grants.values().collect();
        order.sort_by_key(|grant| (u8::MAX - grant.priority, grant.arrival));
        let mut chosen: Vec<&Granted<'_>> = Vec::new();
        for grant in order {
            if self.is_eligible(grant) && self.fits(grant, &chosen) {
                chosen.push(grant);
            }
        }
        chosen.iter().map(|grant| grant.id.serial).collect()
    }

    fn is_eligible(&self, grant: &Granted<'_>) -> bool {
        let faulted = grant.gates().any(|gate| self.faults[gate]);
        let mut scopes: Vec<usize> = vec![0];
        scopes.extend(grant.gates().map(|gate| 1 + usize::from(self.declared(gate).agent)));
        let admits = |scope: usize| self.noticed[scope].admits(Self::priority(grant.priority));
        let above = grant.exempt || scopes.into_iter().all(admits);
        above && !grant.barred && !grant.resting && !faulted
    }

    /// Whether the grant can be valid beside these.
    fn fits(&self, grant: &Granted<'_>, beside: &[&Granted<'_>]) -> bool {
        let taken: Vec<usize> = beside.iter().flat_map(|other| other.gates()).collect();
        let mine: Vec<usize> = grant.gates().collect();
        let agent = |gate: usize| usize::from(self.declared(gate).agent);
        if mine.iter().any(|gate| taken.contains(gate)) {
            return false;
        }
        for &gate in &mine {
            let rules = self.rules(agent(gate));
            let near = |other: &&usize| agent(**other) == agent(gate) && !mine.contains(other);
            let all: Vec<usize> = (0..self.stuck.len()).collect();
            if rules.exclusive && taken.iter().any(|other| near(&other)) {
                return false;
            }
            let conflict = all.iter().filter(near).any(|other| {
                let used = taken.contains(other) || self.is_immovable(*other);
                used && self.declared(*other).categories & self.declared(gate).categories != 0
            });
            if rules.categories && conflict {
                return false;
            }
        }
        (0..self.supply.len()).all(|number| self.margin_allows(number, &mine, &taken))
    }

    fn margin_allows(&self, number: usize, mine: &[usize], taken: &[usize]) -> bool {
        let of_agent = |gate: &usize| usize::from(self.declared(*gate).agent) == number;
        let draw = |gates: Vec<usize>| -> u64 {
            gates.iter().filter(|gate| of_agent(gate)).map(|gate| self.declared(*gate).draw).sum()
        };
        let movable = |gate: &usize| !self.is_immovable(*gate);
        let more = draw(mine.iter().copied().filter(movable).collect());
        let stuck = draw((0..self.stuck.len()).filter(|gate| self.is_immovable(*gate)).collect());
        let others = draw(taken.iter().copied().filter(movable).collect());
        self.rules(number).supply.is_none()
            || more == 0
            || more + stuck + others <= self.supply[number]
    }

    fn is_immovable(&self, gate: usize) -> bool {
        self.stuck[gate] || self.is_hung(gate)
    }

    /// Whether a command there has not come back when it was due.
    fn is_hung(&self, gate: usize) -> bool {
        let id = GateId(u8::try_from(gate).unwrap());
        let state = self.books.device_report(id).unwrap().state;
        state == DeviceState::Stuck && !self.stuck[gate]
    }
}
