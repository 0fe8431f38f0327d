//! What is checked before an activity starts, with what is known now.

use std::collections::BTreeMap;

use super::Control;
use super::outlook::Outlook;
use crate::plan::{Activity, ActivityId, Condition, Kind, Outcome, Variable};
use crate::state::{Mode, Running, State};
use crate::timed::{Limit, Slot, TimedPlan};
use crate::units::{Span, Time};
use crate::{Parameters, Plan};

/// Why an activity cannot start now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotReady {
    /// None of its start ranges is open, or it would not end by its cutoff.
    Range,
    /// The computer is not up.
    Computer,
    /// An activity that it depends on has not ended, or otherwise.
    Dependency(ActivityId),
    /// Another member of its group has started.
    Group(ActivityId),
    /// A variable is not in its range, or unknown.
    Condition(String),
    /// A zone is not warm enough, by its estimate.
    Zone(String),
    /// A limit would be broken, as far as can be seen from here.
    Limit(Limit),
    /// The charge has not recovered from the hard limit.
    Spent,
    /// The charge was not estimated for too long.
    ChargeUnknown,
}

/// What is known when something may start. Who executes a plan asks it, whether
/// by actions or by the schedule manager.
#[derive(Clone, Copy)]
pub(crate) struct Look<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) parameters: &'a Parameters,
    pub(crate) state: &'a State,
    pub(crate) timed: &'a TimedPlan,
    /// What is planned and has not started.
    pub(crate) planned: &'a BTreeMap<ActivityId, Slot>,
    /// Whether a zone is warm enough.
    pub(crate) warm: &'a dyn Fn(&str) -> bool,
    /// The charge has not recovered from the hard limit.
    pub(crate) spent: bool,
}

impl Control {
    /// Whether an activity can start now, and when it would end.
    pub(super) fn ready(&self, id: ActivityId, slot: Slot, early: bool) -> Result<Slot, NotReady> {
        if !self.charge_is_known() {
            return Err(NotReady::ChargeUnknown);
        }
        let look = Look {
            plan: &self.plan,
            parameters: &self.parameters,
            state: &self.state,
            timed: &self.timed,
            planned: &self.planned,
            warm: &|zone| self.is_warm(zone),
            spent: self.spent,
        };
        let slot = look.ready(id, slot, early)?;
        let agrees = self.activity(id).map(|activity| self.timelines_agree(activity, early));
        agrees.unwrap_or(Ok(())).map_err(NotReady::Limit)?;
        Ok(slot)
    }
}

impl Look<'_> {
    /// Whether an activity can start now, and when it would end.
    pub(crate) fn ready(&self, id: ActivityId, slot: Slot, early: bool) -> Result<Slot, NotReady> {
        let Some(activity) = self.activity(id) else { return Err(NotReady::Range) };
        let slot = self.slot_now(activity, slot).ok_or(NotReady::Range)?;
        if self.spent {
            return Err(NotReady::Spent);
        }
        if self.state.mode != Mode::Awake {
            return Err(NotReady::Computer);
        }
        self.priors_agree(activity)?;
        self.group_is_open(activity)?;
        self.conditions_hold(activity)?;
        let cold = activity.zones.iter().find(|zone| !(self.warm)(zone));
        cold.map_or(Ok(()), |zone| Err(NotReady::Zone(zone.clone())))?;
        let outlook = Outlook::new(self.plan, self.parameters, self.state, self.timed);
        outlook.admits(activity, slot, self.planned, early).map_err(NotReady::Limit)?;
        Ok(slot)
    }

    const fn now(&self) -> Time {
        self.state.now
    }

    fn activity(&self, id: ActivityId) -> Option<&Activity> {
        self.plan.activities.iter().find(|activity| activity.id == id)
    }

    fn running(&self, id: ActivityId) -> Option<&Running> {
        self.state.running.iter().find(|running| running.id == id)
    }

    fn outcome(&self, id: ActivityId) -> Option<Outcome> {
        self.state.ended.iter().find(|ended| ended.id == id).map(|ended| ended.outcome)
    }

    /// The same length from now, in the range that was planned or else in any
    /// that is open. Both may be late by the tolerance: what runs is aborted at
    /// its cutoff all the same.
    fn slot_now(&self, activity: &Activity, slot: Slot) -> Option<Slot> {
        let now = self.now();
        let tolerance =
            if slot.start < now { self.parameters.handover_tolerance } else { Span::ZERO };
        let end = self.end_from_now(activity, slot);
        let fits = |index: &usize| {
            activity.starts.get(*index).is_some_and(|range| {
                let cutoff = range.cutoff.min(self.plan.end);
                range.from <= now
                    && now <= range.to.after(tolerance)
                    && end <= cutoff.after(tolerance)
                    && now < cutoff
            })
        };
        let range = Some(slot.range).filter(fits).or((0..activity.starts.len()).find(fits))?;
        Some(Slot { start: now, end, range })
    }

    /// A late expanding activity ends when it was planned to, if that is long
    /// enough: nothing planned moves for it.
    fn end_from_now(&self, activity: &Activity, slot: Slot) -> Time {
        let now = self.now();
        match activity.kind {
            Kind::Expanding { minimum } if slot.start < now => slot.end.max(now.after(minimum)),
            _ => now.after(slot.length()),
        }
    }

    fn priors_agree(&self, activity: &Activity) -> Result<(), NotReady> {
        let agrees = |prior: &&crate::plan::Dependency| {
            let outcome = self.outcome(prior.prior);
            outcome.is_some_and(|outcome| prior.statuses.iter().any(|one| one.includes(outcome)))
        };
        let open = activity.after.iter().find(|prior| !agrees(prior));
        open.map_or(Ok(()), |prior| Err(NotReady::Dependency(prior.prior)))
    }

    fn group_is_open(&self, activity: &Activity) -> Result<(), NotReady> {
        let Some(group) = &activity.group else { return Ok(()) };
        let members = self
            .plan
            .activities
            .iter()
            .filter(|other| other.group.as_ref() == Some(group) && other.id != activity.id);
        let has_started = |id| {
            let ended = self.state.ended.iter().find(|ended| ended.id == id);
            self.running(id).is_some() || ended.is_some_and(|ended| ended.started.is_some())
        };
        let taken = members.map(|other| other.id).find(|id| has_started(*id));
        taken.map_or(Ok(()), |id| Err(NotReady::Group(id)))
    }

    fn conditions_hold(&self, activity: &Activity) -> Result<(), NotReady> {
        let holds = |condition: &&Condition| {
            let value = self.state.variables.get(&condition.name);
            value.is_some_and(|value| (condition.min..=condition.max).contains(value))
        };
        let broken = activity.conditions.iter().find(|condition| !holds(condition));
        broken.map_or(Ok(()), |condition| {
            let kind = match condition.kind {
                Variable::Acm => "ACM",
                Variable::Ddi => "DDI",
            };
            Err(NotReady::Condition(format!("{kind} {}", condition.name)))
        })
    }
}
