//! Timelines that activities name: a wider range of values, of the timeline or
//! of somebody who asks for one; of a unit, not to hold it.

use crate::schedule::place::Trial;
use crate::timed::Limit;
use crate::timeline::{Claim, Timelines};
use crate::units::Time;

use super::super::{Change, Number, Whose};
use super::{Turn, change, halved};

/// Wide enough for everything.
const ANY: (i64, i64) = (i64::MIN, i64::MAX);

impl Turn<'_, '_> {
    /// For each timeline that it names, what would help.
    pub(super) fn named(&self) -> Vec<(String, Vec<Change>)> {
        let claim = self.pass.trial(self.item).claim;
        let lines = claim.named.iter().map(|touch| touch.line);
        let name = |line: usize| self.pass.problem.parameters.timelines[line].name.clone();
        lines.map(|line| (name(line), self.line(line))).collect()
    }

    fn line(&self, line: usize) -> Vec<Change> {
        let mut all = Vec::new();
        if self.with_any_value(line).is_some() {
            for whose in self.who_asks(line) {
                let both = [Number::Least(whose), Number::Most(whose)];
                let both = both.into_iter().filter_map(|number| self.wider(line, number));
                all.extend(both.min_by_key(|it| (it.by, it.start)));
            }
        }
        all.extend(self.without_unit(line));
        all
    }

    /// Whoever may say which values it has: the parameters, itself, and those
    /// that are placed.
    fn who_asks(&self, line: usize) -> Vec<Whose> {
        let name = &self.pass.problem.parameters.timelines[line].name;
        let activities = self.pass.problem.plan.activities.iter().enumerate();
        let there = activities.filter(|(at, _)| *at == self.item || self.pass.slots[*at].is_some());
        let asked = there.flat_map(|(_, activity)| {
            let asked = activity.constraints.iter().enumerate();
            let asked = asked.filter(|(_, constraint)| constraint.timeline == *name);
            asked.map(|(index, _)| Whose::Constraint(activity.id, index))
        });
        core::iter::once(Whose::Timeline).chain(asked).collect()
    }

    fn with_any_value(&self, line: usize) -> Option<i64> {
        let mut claim = self.pass.trial(self.item).claim.clone();
        claim.ask(line, ANY);
        let mut timelines = self.pass.timelines.clone();
        timelines.allow(line, ANY);
        for item in 0..self.pass.slots.len() {
            timelines.ask(line, item, ANY);
        }
        self.start(&timelines, &claim)
    }

    fn start(&self, timelines: &Timelines, claim: &Claim) -> Option<i64> {
        self.fits(&Trial { timelines, claim, ..self.pass.trial(self.item) }, &self.left)
    }

    fn wider(&self, line: usize, number: Number) -> Option<Change> {
        let found = |by: i64| {
            let mut claim = self.pass.trial(self.item).claim.clone();
            let mut timelines = self.pass.timelines.clone();
            let (Number::Least(whose) | Number::Most(whose)) = number else { return None };
            let range = self.range(line, whose, number, by);
            match whose {
                Whose::Timeline => timelines.allow(line, range),
                Whose::Constraint(id, _) if id == self.id => claim.ask(line, range),
                Whose::Constraint(id, _) => {
                    let activities = &self.pass.problem.plan.activities;
                    let item = activities.iter().position(|activity| activity.id == id)?;
                    timelines.ask(line, item, range);
                }
            }
            self.start(&timelines, &claim)
        };
        let start = found(i64::MAX)?;
        // It is off by no more than this there, of that number alone.
        let off = self.off(line, start).unwrap_or(i64::MAX);
        let enough = found(off).map_or((i64::MAX, start), |start| (off, start));
        Some(change(number, halved(enough, found)))
    }

    fn off(&self, line: usize, start: i64) -> Option<i64> {
        let trial = self.pass.trial(self.item);
        let name = &self.pass.problem.parameters.timelines[line].name;
        let mut all = trial.timelines.conflicts(trial.claim, Time::new(start));
        let off = all.find(|it| matches!(&it.limit, Limit::Timeline(other) if other == name));
        off.map(|it| it.amount)
    }

    /// What one of them allows, with one of its numbers changed.
    fn range(&self, line: usize, whose: Whose, number: Number, by: i64) -> (i64, i64) {
        let wider = |(min, max): (i64, i64)| match number {
            Number::Least(_) => (min.saturating_sub(by), max),
            _ => (min, max.saturating_add(by)),
        };
        let spec = &self.pass.problem.parameters.timelines[line];
        let Whose::Constraint(id, index) = whose else { return wider((spec.min, spec.max)) };
        let activity = self.pass.problem.plan.activities.iter().find(|it| it.id == id);
        let asked = activity.into_iter().flat_map(|activity| activity.constraints.iter());
        let asked = asked.enumerate().filter(|(_, it)| it.timeline == spec.name);
        asked.fold(ANY, |(min, max), (at, it)| {
            let range = if at == index { wider((it.min, it.max)) } else { (it.min, it.max) };
            (min.max(range.0), max.min(range.1))
        })
    }

    fn without_unit(&self, line: usize) -> Option<Change> {
        let trial = self.pass.trial(self.item);
        if !trial.timelines.is_unit(line) {
            return None;
        }
        let mut free = trial.claim.clone();
        free.hold_nothing(line);
        let start = self.start(trial.timelines, &free)?;
        let name = &self.pass.problem.parameters.timelines[line].name;
        let mut all = trial.timelines.conflicts(trial.claim, Time::new(start));
        let held = all.find(|it| matches!(&it.limit, Limit::Timeline(other) if other == name));
        let with = held.and_then(|it| it.with);
        let slots = self.pass.slots.iter().enumerate();
        let holder = slots.filter(|(at, _)| Some(self.pass.id(*at)) == with);
        let until = holder.filter_map(|(_, slot)| *slot).map(|slot| slot.end).next();
        Some(Change { with, until, ..change(Number::Without, (0, start)) })
    }
}
