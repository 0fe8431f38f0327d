//! What was decided, as a timed plan.

use crate::derive::World;
use crate::problem::Known;
use crate::timed::{AwakePhase, Fate, Preheat, Reason, Row, TimedPlan};
use crate::units::Time;

use super::Pass;

impl Pass<'_> {
    pub(super) fn answer(&self) -> TimedPlan {
        let rows =
            (0..self.slots.len()).map(|item| Row { id: self.id(item), fate: self.fate(item) });
        TimedPlan {
            rows: rows.collect(),
            awake: awake(&self.world),
            preheats: self.preheats(),
            excess: self.excess.clone(),
            unavoidable: self.unavoidable.clone(),
        }
    }

    fn fate(&self, item: usize) -> Fate {
        let reason = || self.reasons[item].clone().unwrap_or(Reason::NoRangeLeft);
        match (self.problem.items[item].fate, self.slots[item]) {
            (Known::Ended { outcome, .. }, _) => Fate::Ended(outcome),
            (Known::Running { .. }, Some(slot)) => Fate::Running(slot),
            (_, Some(slot)) => Fate::Scheduled(slot),
            (_, None) => Fate::Out(reason()),
        }
    }

    fn preheats(&self) -> Vec<Preheat> {
        let mut all = Vec::new();
        for (line, zone) in self.placed.zones.iter().zip(&self.problem.zones) {
            for heat in line.heats.iter().flatten().filter(|heat| heat.from < heat.to) {
                let (start, end) = (Time::new(heat.from), Time::new(heat.to));
                all.push(Preheat { zone: zone.name.clone(), start, end });
            }
        }
        all.sort_by(|a: &Preheat, b| (a.start, &a.zone).cmp(&(b.start, &b.zone)));
        all
    }
}

fn awake(world: &World) -> Vec<AwakePhase> {
    let phase = |phase: &crate::derive::Phase| AwakePhase {
        wakeup: Time::new(phase.wakeup.at),
        up: Time::new(phase.up.at),
        down: Time::new(phase.down.at),
        asleep: Time::new(phase.asleep.at),
    };
    world.phases.iter().map(phase).collect()
}
