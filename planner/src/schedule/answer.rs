//! What was decided, as a timed plan.

use crate::derive::World;
use crate::problem::Known;
use crate::timed::{AwakePhase, Excess, Fate, Limit, Preheat, Reason, Row, TimedPlan};
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

/// What is broken before anything is planned.
pub(super) fn unavoidable(pass: &Pass<'_>) -> Vec<Excess> {
    let problem = pass.problem;
    let battery = &problem.battery;
    let mut all = Vec::new();
    let mut is = |limit, at: Option<i64>, amount: i64| {
        if let Some(at) = at {
            all.push(Excess { by: None, limit, at: Time::new(at), amount });
        }
    };
    let low = first_below(&pass.world, battery.soft);
    is(Limit::SoftMinimum, low, battery.soft - low.map_or(0, |at| pass.world.charge(at)));
    if let Some(at) = problem.handover {
        let charge = pass.world.charge(at);
        let below = (charge < battery.handover).then_some(at);
        is(Limit::Handover, below, battery.handover - charge);
    }
    let max = problem.plan.max_delta_data.get();
    let data = pass.timelines.volumes(Time::new(problem.now)).find(|(_, total)| *total > max);
    is(Limit::Data, data.map(|(at, _)| at.get()), data.map_or(0, |(_, total)| total - max));
    let peak = pass.world.pieces.iter().find(|piece| piece.peak > problem.peak_limit);
    is(Limit::Peak, peak.map(|it| it.from), peak.map_or(0, |it| it.peak - problem.peak_limit));
    let engines = pass.timelines.engines();
    let most = i64::from(problem.parameters.engines);
    let past = engines.points.iter().find(|(at, used)| at.get() >= problem.now && *used > most);
    is(Limit::Engines, past.map(|(at, _)| at.get()), past.map_or(0, |(_, used)| used - most));
    if let Some(twice) = pass.timelines.held_twice() {
        is(Limit::Resources(twice.bits), Some(twice.at.get()), twice.ms);
    }
    for (name, at, amount) in pass.timelines.out_of_range() {
        is(Limit::Timeline(name.to_owned()), Some(at.get()), amount);
    }
    all
}

/// The first instant at which the charge is below a limit.
fn first_below(world: &World, limit: i64) -> Option<i64> {
    for (at, piece) in world.pieces.iter().enumerate() {
        if piece.charge < limit {
            return Some(piece.from);
        }
        let until = world.until(at);
        if piece.net < 0 && until != i64::MAX && world.charge_in(at, until) < limit {
            return Some(piece.from + (piece.charge - limit) / -piece.net + 1);
        }
    }
    None
}
