//! What was measured, and shortages.

use crate::manager::demand::Demand;
use crate::manager::entry::Stage;
use crate::manager::step::Step;
use crate::manager::{Attempt, Manager, Reading, WaitsFor};
use crate::task::Preemption;

/// What was measured last.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Measured {
    /// Bytes that are available to whoever starts. What was promised since the
    /// measurement is taken off.
    memory: Option<u64>,
    storage: Option<u64>,
    battery: Option<u8>,
    memory_low: bool,
    battery_low: bool,
}

/// A measured use over so many times the estimate is a malfunction.
const TIMES_THE_ESTIMATE: u64 = 2;

impl Step<'_> {
    pub(crate) fn reading(&mut self, reading: Reading) {
        let mission = &self.manager.mission;
        let (memory_low, battery_low) =
            (mission.memory_low, mission.battery.map(|battery| battery.low));
        let measured = &mut self.manager.measured;
        match reading {
            Reading::Battery(percent) => {
                measured.battery = percent;
                // That nothing is known any more does not end a shortage.
                let Some(percent) = percent else { return };
                measured.battery_low = battery_low.is_some_and(|low| percent < low);
                self.relieve(self.manager.measured.battery_low);
            }
            Reading::Memory(bytes) => {
                measured.memory = Some(bytes);
                measured.memory_low = memory_low.is_some_and(|low| bytes < low);
                self.relieve(self.manager.measured.memory_low);
            }
            Reading::Storage(bytes) => measured.storage = Some(bytes),
            Reading::Used { attempt, memory } => self.used(attempt, memory),
        }
    }

    /// With each reading that tells of a shortage one more of those that run
    /// has to stop, the least important one; when it is over, all go on.
    fn relieve(&mut self, is_short: bool) {
        let live = self.manager.live.clone();
        if !is_short && self.manager.shortage().is_some() {
            return;
        }
        if !is_short {
            for index in live {
                if let Some(entry) = self.entry_mut(index) {
                    entry.run.short = false;
                }
            }
            return;
        }
        let running = live.iter().filter_map(|index| Some((*index, self.entry(*index)?)));
        let least = running
            .filter(|(_, entry)| entry.run.stage == Stage::Running && !entry.run.short)
            .filter(|(_, entry)| entry.task.preemption != Preemption::Wait)
            .max_by_key(|(_, entry)| entry.rank());
        if let Some((index, _)) = least
            && let Some(entry) = self.entry_mut(index)
        {
            entry.run.short = true;
        }
    }

    fn used(&mut self, attempt: Attempt, memory: u64) {
        let Some(index) = self.manager.named(attempt.occurrence) else { return };
        let Some(entry) = self.entry(index) else { return };
        let estimate = entry.task.memory;
        let runs = entry.attempts == attempt.number && entry.run.has_body();
        if runs && estimate > 0 && memory > estimate.saturating_mul(TIMES_THE_ESTIMATE) {
            self.fail(index, "it uses more than twice the memory that was estimated");
        }
    }
}

impl Manager {
    /// What there is a shortage of.
    pub(crate) fn shortage(&self) -> Option<WaitsFor> {
        let Measured { memory, battery, memory_low, battery_low, .. } = self.measured;
        if battery_low {
            let wanted = self.mission.battery.map_or(0, |battery| battery.low);
            return Some(WaitsFor::Battery { now: battery, wanted });
        }
        let short_by = self.mission.memory_low.unwrap_or(0).saturating_sub(memory.unwrap_or(0));
        memory_low.then_some(WaitsFor::Memory { short_by })
    }

    /// What was measured, and keeps such a task from starting. `starting` is
    /// the memory and storage of those that are about to start.
    pub(crate) fn keeps_from_starting(
        &self,
        demand: &Demand,
        starting: (u64, u64),
    ) -> Option<WaitsFor> {
        if let Some(shortage) = self.shortage() {
            return Some(shortage);
        }
        let now = self.measured.battery;
        if demand.battery > 0 && now.is_none_or(|percent| percent < demand.battery) {
            return Some(WaitsFor::Battery { now, wanted: demand.battery });
        }
        let short = |there: Option<u64>, promised: u64, wanted: u64| {
            let short = promised.saturating_add(wanted).saturating_sub(there?);
            (wanted > 0 && short > 0).then_some(short)
        };
        let Measured { memory, storage, .. } = self.measured;
        if let Some(short_by) = short(memory, starting.0, demand.memory) {
            return Some(WaitsFor::Memory { short_by });
        }
        short(storage, starting.1, demand.storage).map(|short_by| WaitsFor::Storage { short_by })
    }

    /// What a task that starts now will use is not available to the next one,
    /// until it is measured again.
    pub(crate) fn charge(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        let (memory, storage) = (entry.task.memory, entry.task.storage);
        let take = |there: &mut Option<u64>, taken: u64| {
            *there = there.map(|there| there.saturating_sub(taken));
        };
        take(&mut self.measured.memory, memory);
        take(&mut self.measured.storage, storage);
    }
}
