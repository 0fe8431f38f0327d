//! What a task needs, in the manager's own numbers: what classes of tasks are
//! told apart by.

use crate::mission::Mission;
use crate::task::{Preemption, Task};

/// What a task takes while it runs. Tasks with equal demands wait in one
/// class: only the most important of them needs to be looked at.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Demand {
    /// Its own categories and those of the devices that it commands.
    pub(crate) categories: u128,
    /// Its devices, as bits in the mission's order.
    pub(crate) gates: u128,
    /// Largest draw of each agent, in milliwatts, by the agent's index.
    pub(crate) draws: Vec<(usize, u64)>,
    pub(crate) memory: u64,
    pub(crate) storage: u64,
    /// Percent.
    pub(crate) battery: u8,
    /// Whether it cannot be pre-empted.
    pub(crate) waits: bool,
}

impl Demand {
    /// What the task needs of this mission. Gates that the mission does not
    /// have are left out: tasks that name them are not accepted.
    pub(crate) fn of(task: &Task, mission: &Mission) -> Self {
        let mut demand = Self {
            categories: task.categories.mask(),
            memory: task.memory,
            storage: task.storage,
            battery: task.battery,
            waits: task.preemption == Preemption::Wait,
            ..Self::default()
        };
        demand.draw(0, task.peak_draw.get());
        for gate in &task.gates {
            demand.device(gate, mission);
        }
        demand
    }

    fn device(&mut self, gate: &str, mission: &Mission) {
        let Some(index) = mission.devices.iter().position(|device| device.name == gate) else {
            return;
        };
        let Some(device) = mission.devices.get(index) else { return };
        let bit = bit_of(index);
        if self.gates & bit != 0 {
            return;
        }
        self.gates |= bit;
        self.categories |= device.categories.mask();
        let agent = mission.agents.iter().position(|agent| agent.name == device.agent);
        self.draw(agent.unwrap_or(0), device.draw.map_or(0, |draw| draw.get()));
    }

    fn draw(&mut self, agent: usize, milliwatts: u64) {
        if milliwatts == 0 {
            return;
        }
        match self.draws.iter_mut().find(|(other, _)| *other == agent) {
            Some((_, sum)) => *sum = sum.saturating_add(milliwatts),
            None => {
                self.draws.push((agent, milliwatts));
                self.draws.sort_unstable();
            }
        }
    }

    /// Whether what the two need could ever stand in each other's way.
    pub(crate) fn shares_with(&self, other: &Self) -> bool {
        self.categories & other.categories != 0
            || self.gates & other.gates != 0
            || (self.memory > 0 && other.memory > 0)
            || (self.storage > 0 && other.storage > 0)
            || self
                .draws
                .iter()
                .any(|(agent, _)| other.draws.iter().any(|(other, _)| other == agent))
    }
}

/// The bit of a device. Missions have at most 128 devices.
pub(crate) fn bit_of(index: usize) -> u128 {
    u32::try_from(index).ok().and_then(|index| 1_u128.checked_shl(index)).unwrap_or(0)
}
