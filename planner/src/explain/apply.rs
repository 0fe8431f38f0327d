//! A change, made where its number stands.

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;

use crate::parameters::Parameters;
use crate::plan::{Activity, ActivityId, Effect, Kind, Plan, StartRange};
use crate::timed::Limit;
use crate::units::{Bytes, Ppm, Span};

use super::{Change, Number, Relaxation, Whose};

impl Relaxation {
    /// Makes the change for this activity: with it, the activity has a valid
    /// start at its turn. Nothing, where there is none.
    pub fn apply(&self, id: ActivityId, plan: &mut Plan, parameters: &mut Parameters) {
        let Some(change) = self.change else { return };
        let by = Span::new(change.by);
        let shorter = |span: &mut Span| *span = Span::new(span.get().saturating_sub(change.by));
        match change.number {
            Number::Limit => self.limit(change.by, plan, parameters),
            Number::Least(whose) | Number::Most(whose) => {
                self.values(change, whose, plan, parameters);
            }
            Number::From(range) => starts(plan, id, range, |it| it.from = it.from.before(by)),
            Number::To(range) => starts(plan, id, range, |it| it.to = it.to.after(by)),
            Number::Cutoff(range) => starts(plan, id, range, |it| it.cutoff = it.cutoff.after(by)),
            Number::Shutdown(block) => of(plan, block, |it| shorter(&mut it.duration)),
            Number::Earlier(block) => moved(plan, block, Span::new(change.by.saturating_neg())),
            Number::Later(block) => moved(plan, block, by),
            Number::Heating(zone, row) => {
                let zone = parameters.zones.get_mut(zone);
                if let Some(row) = zone.and_then(|zone| zone.table.get_mut(row)) {
                    shorter(&mut row.duration);
                }
            }
            Number::Wakeup => shorter(&mut parameters.wakeup.duration),
            Number::MinSleep => shorter(&mut parameters.min_sleep),
            Number::Without => self.without(id, change, plan),
        }
    }

    fn limit(&self, by: i64, plan: &mut Plan, parameters: &mut Parameters) {
        let lower = |ppm: &mut Ppm| *ppm = Ppm::new(ppm.get().saturating_sub(by));
        match &self.limit {
            Limit::SoftMinimum => lower(&mut parameters.soft_min_soc),
            Limit::Handover => lower(&mut plan.handover_min_soc),
            Limit::Data => {
                let most = plan.max_delta_data.get().saturating_add(by);
                plan.max_delta_data = Bytes::new(most);
            }
            Limit::Peak => {
                let by = Milliwatts::new(u64::try_from(by).unwrap_or(0));
                parameters.peak_limit = parameters.peak_limit.saturating_add(by);
            }
            Limit::Engines => {
                let by = u32::try_from(by).unwrap_or(u32::MAX);
                parameters.engines = parameters.engines.saturating_add(by);
            }
            _ => {}
        }
    }

    /// A wider range of a timeline's values.
    fn values(&self, change: Change, whose: Whose, plan: &mut Plan, parameters: &mut Parameters) {
        let Limit::Timeline(name) = &self.limit else { return };
        let widen = |min: &mut i64, max: &mut i64| match change.number {
            Number::Least(_) => *min = min.saturating_sub(change.by),
            _ => *max = max.saturating_add(change.by),
        };
        match whose {
            Whose::Timeline => {
                if let Some(line) = parameters.timelines.iter_mut().find(|it| it.name == *name) {
                    widen(&mut line.min, &mut line.max);
                }
            }
            Whose::Constraint(owner, index) => of(plan, owner, |it| {
                if let Some(constraint) = it.constraints.get_mut(index) {
                    widen(&mut constraint.min, &mut constraint.max);
                }
            }),
        }
    }

    fn without(&self, id: ActivityId, change: Change, plan: &mut Plan) {
        match &self.limit {
            Limit::Resources(mask) => of(plan, id, |it| {
                it.resources = Categories::from_mask(it.resources.mask() & !mask);
            }),
            Limit::Timeline(name) => of(plan, id, |it| {
                let holds = |effect| matches!(effect, Effect::Hold(_));
                it.impacts.retain(|it| it.timeline != *name || !holds(it.effect));
            }),
            Limit::Dependency => {
                of(plan, id, |it| it.after.retain(|on| Some(on.prior) != change.with))
            }
            Limit::Computer => {
                if let Some(block) = change.with {
                    of(plan, block, nothing);
                }
            }
            _ => {}
        }
    }
}

/// A manual shutdown of no length.
const fn nothing(block: &mut Activity) {
    block.kind = Kind::ManualShutdown { shutdown: Span::ZERO, wakeup: Span::ZERO };
    block.duration = Span::ZERO;
}

fn of(plan: &mut Plan, id: ActivityId, change: impl FnOnce(&mut Activity)) {
    if let Some(activity) = plan.activities.iter_mut().find(|activity| activity.id == id) {
        change(activity);
    }
}

/// A manual shutdown, so much later.
fn moved(plan: &mut Plan, block: ActivityId, by: Span) {
    starts(plan, block, 0, |it| {
        *it = StartRange {
            from: it.from.after(by),
            to: it.to.after(by),
            cutoff: it.cutoff.after(by),
        };
    });
}

fn starts(plan: &mut Plan, id: ActivityId, range: usize, change: impl FnOnce(&mut StartRange)) {
    of(plan, id, |activity| {
        if let Some(range) = activity.starts.get_mut(range) {
            change(range);
        }
    });
}
