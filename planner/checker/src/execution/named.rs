//! Named timelines: what a plan is made from is what those who started and ended
//! have made of them.

use std::collections::BTreeMap;

use faregate_planner::plan::{ActivityId, Effect};
use faregate_planner::trace::{Happened, Trace};
use faregate_planner::{Parameters, Plan, State};

use crate::violation::{Rule, Violation};

struct Lines<'a> {
    plan: &'a Plan,
    initial: BTreeMap<&'a str, i64>,
    /// In thousandths.
    values: BTreeMap<&'a str, i128>,
    /// Who runs and is not paused.
    working: Vec<ActivityId>,
    now: i64,
}

pub(super) fn check(plan: &Plan, parameters: &Parameters, trace: &Trace) -> Vec<Violation> {
    let mut lines = Lines {
        plan,
        initial: BTreeMap::new(),
        values: BTreeMap::new(),
        working: Vec::new(),
        now: trace.begin.get(),
    };
    let mut wrong = Vec::new();
    for entry in &trace.entries {
        lines.pass(entry.at.get());
        match &entry.what {
            Happened::Planned { state, .. } if lines.values.is_empty() => {
                lines.begin(parameters, state);
            }
            Happened::Planned { state, .. } => wrong.extend(lines.told(state)),
            Happened::Dispatched(dispatch) => {
                lines.working.push(dispatch.id);
                lines.starts(dispatch.id);
            }
            Happened::Ended { id, .. } | Happened::Aborted { id, .. } => {
                lines.working.retain(|other| other != id);
                lines.ends(*id);
            }
            Happened::Paused(id) => lines.working.retain(|other| other != id),
            Happened::Resumed(id) => lines.working.push(*id),
            Happened::HandedOver(next) => lines.plan = next,
            _ => {}
        }
    }
    wrong
}

impl<'a> Lines<'a> {
    fn begin(&mut self, parameters: &'a Parameters, state: &State) {
        let running: Vec<_> = state.running.iter().map(|running| running.id).collect();
        for spec in &parameters.timelines {
            let told = state.timelines.get(&spec.name).copied();
            let value = i128::from(told.unwrap_or(spec.initial)) * 1_000;
            self.values.insert(&spec.name, value);
            self.initial.insert(&spec.name, spec.initial);
            if told.is_none() {
                running.iter().for_each(|id| self.hold(*id, &spec.name, 1_000));
            }
        }
        let working = state.running.iter().filter(|running| running.paused.is_none());
        self.working = working.map(|running| running.id).collect();
    }

    fn effects(&self, id: ActivityId) -> Vec<(&'a str, Effect)> {
        let activity = self.plan.activities.iter().find(|activity| activity.id == id);
        let impacts = activity.into_iter().flat_map(|activity| &activity.impacts);
        impacts.map(|impact| (impact.timeline.as_str(), impact.effect)).collect()
    }

    fn add(&mut self, name: &str, thousandths: i128) {
        if let Some(value) = self.values.get_mut(name) {
            *value += thousandths;
        }
    }

    fn set(&mut self, name: &str, to: i64) {
        if let Some(value) = self.values.get_mut(name) {
            *value = i128::from(to) * 1_000;
        }
    }

    fn hold(&mut self, id: ActivityId, name: &str, times: i128) {
        for (line, effect) in self.effects(id) {
            if let (true, Effect::Hold(amount)) = (line == name, effect) {
                self.add(name, i128::from(amount) * times);
            }
        }
    }

    fn pass(&mut self, at: i64) {
        let ms = i128::from(at - self.now);
        self.now = at;
        for id in self.working.clone() {
            for (name, effect) in self.effects(id) {
                if let Effect::Rate(rate) = effect {
                    self.add(name, i128::from(rate) * ms);
                }
            }
        }
    }

    fn starts(&mut self, id: ActivityId) {
        for (name, effect) in self.effects(id) {
            match effect {
                Effect::SetAtStart(to) => self.set(name, to),
                Effect::Hold(amount) | Effect::AddAtStart(amount) => {
                    self.add(name, i128::from(amount) * 1_000);
                }
                Effect::SetAtEnd(_) | Effect::AddAtEnd(_) | Effect::Rate(_) => {}
            }
        }
    }

    fn ends(&mut self, id: ActivityId) {
        for (name, effect) in self.effects(id) {
            match effect {
                Effect::SetAtEnd(to) => self.set(name, to),
                Effect::Hold(amount) => self.add(name, i128::from(amount) * -1_000),
                Effect::AddAtEnd(amount) => self.add(name, i128::from(amount) * 1_000),
                Effect::SetAtStart(_) | Effect::AddAtStart(_) | Effect::Rate(_) => {}
            }
        }
    }

    /// What the state is silent about is its initial value, and what running ones
    /// hold of it.
    fn told(&self, state: &State) -> Option<Violation> {
        let silent = |name: &str| {
            let initial = self.initial.get(name).copied().unwrap_or(0);
            let running = state.running.iter().flat_map(|running| self.effects(running.id));
            let held = running.map(|(line, effect)| match effect {
                Effect::Hold(amount) if line == name => i128::from(amount),
                _ => 0,
            });
            i128::from(initial) + held.sum::<i128>()
        };
        let told = |name: &str| {
            state.timelines.get(name).map_or_else(|| silent(name), |told| i128::from(*told))
        };
        let truly = |value: &i128| value.div_euclid(1_000);
        let (name, value) = self.values.iter().find(|(name, value)| told(name) != truly(value))?;
        let detail = format!("{name}: {} and not {}", truly(value), told(name));
        Some(Violation::new(Rule::TimelinesTold, None, self.now).detail(detail))
    }
}
