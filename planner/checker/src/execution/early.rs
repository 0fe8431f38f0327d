//! Early starts: nothing planned has to start later because of one.

use std::collections::BTreeMap;

use faregate_planner::plan::{Activity, ActivityId};
use faregate_planner::timed::{Fate, Slot, TimedPlan};
use faregate_planner::trace::{Dispatch, Happened, Trace};
use faregate_planner::units::Time;
use faregate_planner::{Parameters, Plan};

use crate::violation::{Rule, Violation};

/// What runs, and what is planned to.
struct Early<'a> {
    plan: &'a Plan,
    parameters: &'a Parameters,
    /// Until when each is expected to run.
    runs: BTreeMap<ActivityId, Time>,
    planned: BTreeMap<ActivityId, Slot>,
}

pub(super) fn check(plan: &Plan, parameters: &Parameters, trace: &Trace) -> Vec<Violation> {
    let (runs, planned) = (BTreeMap::new(), BTreeMap::new());
    let mut early = Early { plan, parameters, runs, planned };
    let mut wrong = Vec::new();
    for entry in &trace.entries {
        match &entry.what {
            Happened::Planned { timed, .. } => early.plans(timed),
            Happened::Dispatched(dispatch) => {
                early.planned.remove(&dispatch.id);
                if dispatch.early {
                    wrong.extend(early.beside(entry.at, dispatch));
                }
                early.runs.insert(dispatch.id, dispatch.ends);
            }
            Happened::NotStarted { id, .. } => {
                early.planned.remove(id);
            }
            Happened::Ended { id, .. } | Happened::Aborted { id, .. } => {
                early.runs.remove(id);
            }
            Happened::HandedOver(next) => {
                early.plan = next;
                early.planned.clear();
            }
            _ => {}
        }
    }
    wrong
}

impl Early<'_> {
    fn plans(&mut self, timed: &TimedPlan) {
        let slots = timed.rows.iter().filter_map(|row| match row.fate {
            Fate::Scheduled(slot) => Some((row.id, slot)),
            _ => None,
        });
        self.planned = slots.filter(|(id, _)| !self.runs.contains_key(id)).collect();
    }

    fn activity(&self, id: ActivityId) -> Option<&Activity> {
        self.plan.activities.iter().find(|activity| activity.id == id)
    }

    /// Whoever starts while it runs finds its bits free, and engines and power
    /// left. Its end may overlap by what a start may be late.
    fn beside(&self, now: Time, dispatch: &Dispatch) -> Option<Violation> {
        let mine = self.activity(dispatch.id)?;
        let until = dispatch.ends.before(self.parameters.handover_tolerance);
        let mut starts =
            self.planned.iter().filter(|(_, slot)| now < slot.start && slot.start < until);
        let (other, why) = starts.find_map(|(id, slot)| {
            let other = self.activity(*id)?;
            self.lacks(mine, other, now, slot.start).map(|what| (id, what))
        })?;
        let violation = Violation::new(Rule::EarlyBeside, Some(dispatch.id), now.get());
        Some(violation.detail(format!("{other}, for want of {why}")))
    }

    /// What another one lacks that is to start then.
    fn lacks(
        &self,
        mine: &Activity,
        other: &Activity,
        now: Time,
        at: Time,
    ) -> Option<&'static str> {
        let both = |of: fn(&Activity) -> u64| of(mine) > 0 && of(other) > 0;
        let sum = |of: fn(&Activity) -> u64| {
            let others = self.at(now, at).map(|one| u128::from(of(one)));
            others.sum::<u128>() + u128::from(of(mine))
        };
        let engines = |one: &Activity| u64::from(one.engines);
        let peak = |one: &Activity| one.peak.get();
        // Windows and heating draw besides: this is the least that is drawn.
        let drawn = sum(peak) + u128::from(self.parameters.awake.peak.get());
        if other.resources.overlaps(mine.resources) {
            Some("a bit")
        } else if both(engines) && sum(engines) > self.parameters.engines.into() {
            Some("engines")
        } else if both(peak) && drawn > self.parameters.peak_limit.get().into() {
            Some("power")
        } else {
            None
        }
    }

    /// What is planned to run then. Who is due and waits is late already, whoever
    /// starts.
    fn at(&self, now: Time, at: Time) -> impl Iterator<Item = &Activity> {
        let planned = self.planned.iter().filter(move |(_, slot)| now < slot.start);
        let planned = planned.filter(move |(_, slot)| slot.start <= at && at < slot.end);
        let running = self.runs.iter().filter(move |(_, ends)| at < **ends);
        let ids = planned.map(|(id, _)| id).chain(running.map(|(id, _)| id));
        ids.filter_map(|id| self.activity(*id))
    }
}
