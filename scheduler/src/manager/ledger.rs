//! What is taken of everything that tasks share.

use crate::manager::demand::Demand;
use crate::mission::Mission;

/// What there is. `None`: it is not counted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Installed {
    /// The supply of each agent, in milliwatts.
    pub(crate) supplies: Vec<Option<u64>>,
    pub(crate) memory: Option<u64>,
    pub(crate) storage: Option<u64>,
    pub(crate) battery: bool,
}

/// What has been taken.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger {
    pub(crate) categories: u128,
    pub(crate) gates: u128,
    draws: Vec<u64>,
    memory: u64,
    storage: u64,
}

/// What there is not enough of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Short {
    Categories(u128),
    Gates(u128),
    /// Milliwatts.
    Draw(u64),
    /// Bytes.
    Memory(u64),
    /// Bytes.
    Storage(u64),
}

/// Which part of a demand is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// What only a running body takes: categories, gates, draw.
    Running,
    /// Memory and storage, too.
    All,
}

impl Installed {
    pub(crate) fn of(mission: &Mission) -> Self {
        let supplies =
            mission.agents.iter().map(|agent| agent.supply.map(|supply| supply.get())).collect();
        Self {
            supplies,
            memory: mission.memory,
            storage: mission.storage,
            battery: mission.battery.is_some(),
        }
    }

    fn supply(&self, agent: usize) -> Option<u64> {
        self.supplies.get(agent).copied().flatten()
    }
}

impl Ledger {
    /// An empty one for these agents.
    pub(crate) fn new(installed: &Installed) -> Self {
        Self { draws: vec![0; installed.supplies.len()], ..Self::default() }
    }

    /// What is missing of the demand, if anything is.
    pub(crate) fn short(&self, demand: &Demand, part: Part, there: &Installed) -> Option<Short> {
        let categories = self.categories & demand.categories;
        if categories != 0 {
            return Some(Short::Categories(categories));
        }
        let gates = self.gates & demand.gates;
        if gates != 0 {
            return Some(Short::Gates(gates));
        }
        for (agent, draw) in &demand.draws {
            if let Some(short) = short_by(self.drawn(*agent), *draw, there.supply(*agent)) {
                return Some(Short::Draw(short));
            }
        }
        if part == Part::Running {
            return None;
        }
        let memory = short_by(self.memory, demand.memory, there.memory).map(Short::Memory);
        memory.or_else(|| short_by(self.storage, demand.storage, there.storage).map(Short::Storage))
    }

    pub(crate) fn take(&mut self, demand: &Demand, part: Part) {
        self.categories |= demand.categories;
        self.gates |= demand.gates;
        for (agent, draw) in &demand.draws {
            if let Some(drawn) = self.draws.get_mut(*agent) {
                *drawn = drawn.saturating_add(*draw);
            }
        }
        if part == Part::All {
            self.reserve(demand);
        }
    }

    /// Takes only memory and storage.
    pub(crate) fn reserve(&mut self, demand: &Demand) {
        self.memory = self.memory.saturating_add(demand.memory);
        self.storage = self.storage.saturating_add(demand.storage);
    }

    fn drawn(&self, agent: usize) -> u64 {
        self.draws.get(agent).copied().unwrap_or(0)
    }
}

fn short_by(taken: u64, wanted: u64, there: Option<u64>) -> Option<u64> {
    if wanted == 0 {
        return None;
    }
    let short = taken.saturating_add(wanted).saturating_sub(there?);
    (short > 0).then_some(short)
}
