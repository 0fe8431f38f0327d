//! Flexible execution: when something ended early, failed or was vetoed, what is
//! planned next may start at once.

use super::Control;

impl Control {
    /// In the order of importance, whatever can start without anything planned
    /// having to start later for it.
    pub(super) fn start_early(&mut self) {
        if !std::mem::take(&mut self.freed) || !self.options.early_starts {
            return;
        }
        let now = self.now();
        let later = |(id, slot): (&crate::ActivityId, &crate::timed::Slot)| {
            (slot.start > now && !self.asked.contains_key(id)).then_some((*id, *slot))
        };
        let candidates = self.by_importance(self.planned.iter().filter_map(later).collect());
        for (id, slot) in candidates {
            // Whoever was asked for before it counts as planned to start now.
            if self.ready(id, slot, true).is_ok() && !self.is_in_the_way_of_asked(id) {
                self.ask(id, true);
            }
        }
    }

    /// Two that start together must fit together: the second one comes at the
    /// next opportunity, when the first one runs.
    fn is_in_the_way_of_asked(&self, id: crate::ActivityId) -> bool {
        let bits = |id| self.activity(id).map_or(0, |one| one.resources.mask());
        let others = self.asked.keys().filter(|other| **other != id);
        let power = |id| self.activity(id).map_or(0, |one| one.peak.get());
        let engines = |id| self.activity(id).map_or(0, |one| u64::from(one.engines));
        let shares = others.clone().any(|other| bits(*other) & bits(id) != 0);
        let loads = others.clone().chain([&id]).map(|other| power(*other));
        let peak = loads.fold(self.present_peak(), u64::saturating_add);
        let used = others.chain([&id]).map(|other| engines(*other));
        let used = used.sum::<u64>() + self.engines_in_use();
        shares || peak > self.parameters.peak_limit.get() || used > self.parameters.engines.into()
    }

    fn present_peak(&self) -> u64 {
        let running = self.state.running.iter().filter_map(|one| self.activity(one.id));
        let heaters = self.parameters.zones.iter();
        let heaters = heaters.filter(|zone| self.state.heating.contains_key(&zone.name));
        let heating = heaters.map(|zone| zone.load.peak.get());
        let computer = self.parameters.awake.peak.get();
        running.map(|one| one.peak.get()).chain(heating).fold(computer, u64::saturating_add)
    }

    fn engines_in_use(&self) -> u64 {
        let running = self.state.running.iter().filter_map(|one| self.activity(one.id));
        running.map(|one| u64::from(one.engines)).sum()
    }
}
