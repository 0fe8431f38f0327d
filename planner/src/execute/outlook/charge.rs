//! The charge from now to the plan's end, with and without an activity.

use std::collections::{BTreeMap, BTreeSet};

use super::Outlook;
use crate::plan::{Activity, ActivityId};
use crate::state::Mode;
use crate::timed::{Limit, Slot};
use crate::units::{Ppm, Time};

/// A load that is drawn for a time: half-open, in mW.
type Load = (Time, Time, i64);

impl Outlook<'_> {
    /// Nowhere below the soft minimum and lower than without it; optional ones
    /// likewise at handover.
    pub(super) fn keeps_charge(
        &self,
        activity: &Activity,
        slot: Slot,
        planned: &BTreeMap<ActivityId, Slot>,
    ) -> Result<(), Limit> {
        let loads = self.loads(activity.id, planned);
        let mine = (slot.start, slot.end, milliwatts(activity.marginal.get()));
        let extra = self.computer_for(slot);
        let mut instants = instants(&loads, self.state.now, self.plan.end);
        instants.extend([slot.start, slot.end, self.plan.handover]);
        instants.extend(extra.iter().flat_map(|(from, to, _)| [*from, *to]));
        let ends = |at: &Time| self.state.now <= *at && *at <= self.plan.end;
        let instants: Vec<_> = instants.into_iter().filter(ends).collect();
        let without = self.line(&instants, &loads);
        let with_it: Vec<_> = loads.into_iter().chain([mine]).chain(extra).collect();
        let with_it = self.line(&instants, &with_it);
        for ((at, with), without) in instants.iter().zip(with_it).zip(without) {
            let worse = with < without;
            if worse && self.is_below(with, self.parameters.soft_min_soc) {
                return Err(Limit::SoftMinimum);
            }
            let handover = *at == self.plan.handover && !self.is_mandatory(activity);
            if worse && handover && self.is_below(with, self.plan.handover_min_soc) {
                return Err(Limit::Handover);
            }
        }
        Ok(())
    }

    /// Everything that draws, beside the base load and this activity.
    fn loads(&self, but: ActivityId, planned: &BTreeMap<ActivityId, Slot>) -> Vec<Load> {
        let now = self.state.now;
        let marginal = |id| self.activity(id).map_or(0, |one| milliwatts(one.marginal.get()));
        let running = self.state.running.iter().filter(|running| running.paused.is_none());
        let running = running.map(|one| (now, one.ends.max(now), marginal(one.id)));
        let planned = planned.iter().filter(|(id, _)| **id != but);
        let planned = planned.map(|(id, slot)| (slot.start, slot.end, marginal(*id)));
        let windows = self.state.windows.iter();
        let windows = windows.map(|one| (one.start, one.end, milliwatts(one.marginal.get())));
        let heating = self.timed.preheats.iter().map(|heating| {
            let zone = self.parameters.zones.iter().find(|zone| zone.name == heating.zone);
            let draws = zone.map_or(0, |zone| milliwatts(zone.load.marginal.get()));
            (heating.start, heating.end, draws)
        });
        running.chain(planned).chain(windows).chain(heating).chain(self.computer()).collect()
    }

    fn computer(&self) -> Vec<Load> {
        let parameters = self.parameters;
        let load = |load: crate::parameters::Load| milliwatts(load.marginal.get());
        let mut loads = Vec::new();
        for phase in &self.timed.awake {
            loads.push((phase.wakeup, phase.up, load(parameters.wakeup.load)));
            loads.push((phase.up, phase.down, load(parameters.awake)));
            loads.push((phase.down, phase.asleep, load(parameters.shutdown.load)));
        }
        loads
    }

    /// The computer stays up for it longer than planned.
    fn computer_for(&self, slot: Slot) -> Vec<Load> {
        let up = self.state.mode == Mode::Awake;
        let down = self.timed.awake.iter().filter(|phase| phase.up <= slot.start);
        let down = down.map(|phase| phase.down).filter(|down| *down > slot.start).max();
        let from = down.unwrap_or(slot.start);
        let draws = milliwatts(self.parameters.awake.marginal.get());
        if up && from < slot.end { vec![(from, slot.end, draws)] } else { Vec::new() }
    }

    /// The charge at each of these instants, in order, from the first one.
    fn line(&self, instants: &[Time], loads: &[Load]) -> Vec<i128> {
        let capacity = i128::from(self.state.capacity.get());
        let given = i128::from(self.parameters.rtg.get()) - i128::from(self.parameters.base.get());
        let mut charge = i128::from(self.state.charge.get());
        let mut line = Vec::with_capacity(instants.len());
        let mut before = instants.first().copied();
        for at in instants {
            if let Some(before) = before.replace(*at) {
                let drawn = loads.iter().filter(|(from, to, _)| *from <= before && before < *to);
                let drawn: i128 = drawn.map(|(.., draws)| i128::from(*draws)).sum();
                let time = i128::from(at.since(before).get());
                charge = (charge + (given - drawn) * time).min(capacity);
            }
            line.push(charge);
        }
        line
    }

    fn is_below(&self, charge: i128, limit: Ppm) -> bool {
        charge * 1_000_000 < i128::from(limit.get()) * i128::from(self.state.capacity.get())
    }
}

fn instants(loads: &[Load], now: Time, end: Time) -> BTreeSet<Time> {
    loads.iter().flat_map(|(from, to, _)| [*from, *to]).chain([now, end]).collect()
}

fn milliwatts(mw: u64) -> i64 {
    i64::try_from(mw).unwrap_or(i64::MAX)
}
