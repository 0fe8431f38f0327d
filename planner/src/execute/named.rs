//! Named timelines: what starts, runs and ends changes them, and a new plan is
//! made from what they are.
//!
//! Values are kept in thousandths, since rates are per second and time passes in
//! milliseconds; what a plan is made from is rounded down.

use std::collections::BTreeMap;

use super::Control;
use crate::parameters::Parameters;
use crate::plan::{Activity, ActivityId, Effect, Impact, Plan};
use crate::state::State;
use crate::timed::Limit;
use crate::units::Time;

const THOUSAND: i64 = 1_000;

/// Values of named timelines, in thousandths.
#[derive(Clone, Debug, Default)]
pub(crate) struct Values(BTreeMap<String, i64>);

impl Values {
    /// Where the state is silent: the initial value, with what running ones hold.
    pub(crate) fn begin(plan: &Plan, parameters: &Parameters, state: &State) -> Self {
        let running = |activity: &&Activity| state.running.iter().any(|one| one.id == activity.id);
        let impacts = || plan.activities.iter().filter(running).flat_map(|one| &one.impacts);
        let held = |name: &str| -> i64 {
            let holds = impacts().filter(|impact| impact.timeline == name);
            holds
                .map(|impact| if let Effect::Hold(amount) = impact.effect { amount } else { 0 })
                .sum()
        };
        let value = |name: &str, initial: i64| {
            let known = state.timelines.get(name).copied();
            known.unwrap_or_else(|| initial.saturating_add(held(name))).saturating_mul(THOUSAND)
        };
        let specs = parameters.timelines.iter();
        Self(specs.map(|spec| (spec.name.clone(), value(&spec.name, spec.initial))).collect())
    }

    /// Time goes on: what runs changes timelines at its rates.
    pub(crate) fn pass(&mut self, plan: &Plan, state: &mut State, now: Time) {
        let ms = now.since(state.now).get();
        let running = state.running.iter().filter(|running| running.paused.is_none());
        let working: Vec<_> = running.map(|running| running.id).collect();
        state.now = now;
        for id in working {
            self.change(plan, state, id, |effect, value| match effect {
                Effect::Rate(rate) => value.saturating_add(rate.saturating_mul(ms)),
                _ => value,
            });
        }
    }

    pub(crate) fn starts(&mut self, plan: &Plan, state: &mut State, id: ActivityId) {
        self.change(plan, state, id, |effect, value| match effect {
            Effect::SetAtStart(to) => to.saturating_mul(THOUSAND),
            Effect::Hold(amount) | Effect::AddAtStart(amount) => {
                value.saturating_add(amount.saturating_mul(THOUSAND))
            }
            _ => value,
        });
    }

    pub(crate) fn ends(&mut self, plan: &Plan, state: &mut State, id: ActivityId) {
        self.change(plan, state, id, |effect, value| match effect {
            Effect::SetAtEnd(to) => to.saturating_mul(THOUSAND),
            Effect::Hold(amount) => value.saturating_sub(amount.saturating_mul(THOUSAND)),
            Effect::AddAtEnd(amount) => value.saturating_add(amount.saturating_mul(THOUSAND)),
            _ => value,
        });
    }

    fn change(
        &mut self,
        plan: &Plan,
        state: &mut State,
        id: ActivityId,
        change: impl Fn(Effect, i64) -> i64,
    ) {
        let Some(activity) = plan.activities.iter().find(|one| one.id == id) else { return };
        for impact in &activity.impacts {
            let Some(value) = self.0.get_mut(&impact.timeline) else { continue };
            let changed = change(impact.effect, *value);
            if changed != *value {
                *value = changed;
                let shown = changed.div_euclid(THOUSAND);
                state.timelines.insert(impact.timeline.clone(), shown);
            }
        }
    }

    fn get(&self, name: &str) -> i64 {
        self.0.get(name).copied().unwrap_or(0)
    }
}

impl Control {
    pub(super) fn pass(&mut self, now: Time) {
        self.named.pass(&self.plan, &mut self.state, now);
    }

    pub(super) fn changes_at_start(&mut self, id: ActivityId) {
        self.named.starts(&self.plan, &mut self.state, id);
    }

    pub(super) fn changes_at_end(&mut self, id: ActivityId) {
        self.named.ends(&self.plan, &mut self.state, id);
    }

    /// At its time: what it asks for is so now. Before its time, besides: nobody
    /// who runs or is planned has to do with its timelines. That refuses more than
    /// it must, and needs no projection.
    pub(super) fn timelines_agree(&self, activity: &Activity, early: bool) -> Result<(), Limit> {
        let holds = |name: &str, min: i64, max: i64| {
            let value = self.named.get(name);
            min.saturating_mul(THOUSAND) <= value && value <= max.saturating_mul(THOUSAND)
        };
        let broken = activity.constraints.iter().find(|asked| {
            let sets = activity.impacts.iter().any(|one| one.timeline == asked.timeline);
            !sets && !holds(&asked.timeline, asked.min, asked.max)
        });
        let full = activity.impacts.iter().find(|impact| self.is_too_much(impact));
        let broken = broken.map(|asked| &asked.timeline).or(full.map(|impact| &impact.timeline));
        let met = early.then(|| self.met(activity)).flatten();
        broken.or(met).map_or(Ok(()), |name| Err(Limit::Timeline(name.clone())))
    }

    /// Whether there is no room for what it takes or adds at its start.
    fn is_too_much(&self, impact: &Impact) -> bool {
        let (Effect::Hold(amount) | Effect::AddAtStart(amount)) = impact.effect else {
            return false;
        };
        let spec = self.parameters.timelines.iter().find(|spec| spec.name == impact.timeline);
        let value = self.named.get(&impact.timeline);
        let after = value.saturating_add(amount.saturating_mul(THOUSAND));
        spec.is_some_and(|spec| {
            amount > 0 && after > spec.max.saturating_mul(THOUSAND)
                || amount < 0 && after < spec.min.saturating_mul(THOUSAND)
        })
    }

    /// A timeline that another one has to do with, too.
    fn met<'a>(&self, activity: &'a Activity) -> Option<&'a String> {
        let running = self.state.running.iter().map(|running| running.id);
        let others = running.chain(self.planned.keys().copied()).filter(|id| *id != activity.id);
        let others: Vec<_> = others.filter_map(|id| self.activity(id)).collect();
        let mut mine = names(activity);
        mine.find(|name| others.iter().any(|other| names(other).any(|theirs| theirs == *name)))
    }
}

/// Timelines that it changes, or asks something of.
fn names(activity: &Activity) -> impl Iterator<Item = &String> {
    let impacts = activity.impacts.iter().map(|impact| &impact.timeline);
    impacts.chain(activity.constraints.iter().map(|asked| &asked.timeline))
}
