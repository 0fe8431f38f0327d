//! A timeline that activities name, of any kind.

use std::collections::BTreeMap;

use crate::parameters::{TimelineKind, TimelineSpec};
use crate::plan::{Activity, Effect, Kind, Plan};
use crate::state::State;
use crate::units::Time;

use super::claim::{Claim, FINE, Touch};
use super::line::Line;
use super::settings::{Range, Setter, Settings};
use super::starts::{Bad, Keep, Part, Within, outside, worse};
use super::{add, at_most};

/// Its result, its limits, and what placed activities ask of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) min: i64,
    pub(super) max: i64,
    pub(super) result: Outcome,
    /// How many hold it: a unit's second user is one too many.
    pub(super) holders: Option<Line>,
    /// By start and by who asks.
    keeps: BTreeMap<(i64, usize), Range>,
    end: i64,
}

/// Values that are added up, or values that are set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Sum(Line),
    Set(Settings),
}

impl Named {
    pub(super) fn new(
        spec: &TimelineSpec,
        plan: &Plan,
        state: &State,
        (now, end): (i64, i64),
    ) -> Self {
        let value = present(spec, plan, state);
        let result = match spec.kind {
            TimelineKind::State => Outcome::Set(Settings::new(value, end)),
            _ => Outcome::Sum(Line::new(now, end, i128::from(value) * FINE)),
        };
        let unit = spec.kind == TimelineKind::Unit;
        Self {
            name: spec.name.clone(),
            min: spec.min,
            max: spec.max,
            result,
            holders: unit.then(|| Line::new(now, end, 0)),
            keeps: BTreeMap::new(),
            end,
        }
    }

    pub(super) fn change(&mut self, touch: &Touch, claim: &Claim, start: i64, sign: i128) {
        match &mut self.result {
            Outcome::Sum(line) => {
                // What a running one holds, the present value has in it.
                for &part in &touch.parts {
                    add(line, part, start, sign);
                }
            }
            Outcome::Set(set) if sign > 0 => set.insert(setter(touch, claim), start),
            Outcome::Set(set) => set.remove(setter(touch, claim), start),
        }
        if let (Some(holders), true) = (&mut self.holders, touch.holds) {
            add(holders, one(claim), start, sign);
        }
        let end = start.saturating_add(claim.length);
        match touch.keep {
            Some((min, max)) if start < end && sign > 0 => {
                let range = Range { from: start, to: end, min, max };
                self.keeps.insert((start, claim.order), range);
            }
            _ => drop(self.keeps.remove(&(start, claim.order))),
        }
    }

    pub(super) fn bad(&self, touch: &Touch, claim: &Claim, within: Within, bad: &mut Bad) {
        match &self.result {
            Outcome::Sum(line) => self.bad_sums(line, touch, claim, within, bad),
            Outcome::Set(set) => set.bad(setter(touch, claim), &self.ranges(), within, bad),
        }
        if let (Some(holders), true) = (&self.holders, touch.holds) {
            worse(holders, &[one(claim)], at_most(1), within, bad);
        }
    }

    fn bad_sums(&self, line: &Line, touch: &Touch, claim: &Claim, within: Within, bad: &mut Bad) {
        if !touch.parts.is_empty() {
            for range in self.ranges() {
                worse(line, &touch.parts, keep(range), within, bad);
            }
        }
        if let Some((min, max)) = touch.keep {
            let own = Range { from: i64::MIN, to: i64::MAX, min, max };
            outside(line, &during(touch, claim), keep(own), within, bad);
        }
    }

    /// Others are asked of it by something that is placed.
    pub(super) fn ask(&mut self, order: usize, (min, max): (i64, i64)) {
        for ((_, by), range) in &mut self.keeps {
            if *by == order {
                (range.min, range.max) = (min, max);
            }
        }
    }

    /// What must be kept: by everybody, and for those that are placed.
    pub(super) fn ranges(&self) -> Vec<Range> {
        let always = Range { from: i64::MIN, to: self.end, min: self.min, max: self.max };
        core::iter::once(always).chain(self.keeps.values().copied()).collect()
    }
}

pub(super) fn keep(range: Range) -> Keep {
    let Range { from, to, min, max } = range;
    Keep { from, to, min: i128::from(min) * FINE, max: i128::from(max) * FINE }
}

pub(super) const fn setter(touch: &Touch, claim: &Claim) -> Setter {
    Setter { order: claim.order, length: claim.length, sets: touch.sets, keep: touch.keep }
}

pub(super) const fn one(claim: &Claim) -> Part {
    Part { from: 0, to: claim.length, value: 1, slope: 0 }
}

/// What it adds while it runs; nothing is something, too.
pub(super) fn during(touch: &Touch, claim: &Claim) -> Vec<Part> {
    let own = touch.parts.iter().copied().find(|part| part.from == 0 && part.to == claim.length);
    let nothing = Part { from: 0, to: claim.length, value: 0, slope: 0 };
    let part = own.unwrap_or(nothing);
    if part.to > 0 { vec![part] } else { Vec::new() }
}

/// The value that others find now: holds of what has begun are in it, and are
/// taken out here, since what is left of it is inserted with them.
fn present(spec: &TimelineSpec, plan: &Plan, state: &State) -> i64 {
    let Some(&value) = state.timelines.get(&spec.name) else {
        return spec.initial;
    };
    let begun = plan.activities.iter().filter(|activity| has_begun(activity, state));
    let impacts = begun.flat_map(|activity| &activity.impacts);
    let held = impacts.filter(|impact| impact.timeline == spec.name);
    held.fold(value, |value, impact| match impact.effect {
        Effect::Hold(amount) => value.saturating_sub(amount),
        _ => value,
    })
}

/// Whether it runs, or is a manual shutdown that now is in.
fn has_begun(activity: &Activity, state: &State) -> bool {
    let is_manual = matches!(activity.kind, Kind::ManualShutdown { .. });
    let from = activity.starts.first().map(|range| range.from);
    let is_in = |from: Time| from < state.now && state.now < from.after(activity.duration);
    let ended = || state.ended.iter().any(|ended| ended.id == activity.id);
    state.running.iter().any(|running| running.id == activity.id)
        || is_manual && from.is_some_and(is_in) && !ended()
}
