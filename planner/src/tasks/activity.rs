//! An activity as a task.

use faregate_scheduler::Mission;
use faregate_scheduler::manager::limits::LATENESS;
use faregate_scheduler::task::{
    Body, Dependency, Overrun, Preemption, Status as TaskStatus, Step, Task, TaskId,
};
use faregate_scheduler::tickets::MOST_GATES;
use faregate_scheduler::time::Duration;

use super::generated::Generated;
use super::translate::{Given, Held, devices, duration, hold_length};
use super::{Misfit, library};
use crate::plan::{Activity, Dependency as Prior, Kind, Outcome};
use crate::timed::{AwakePhase, Fate, Slot};
use crate::units::{Span, Time};

impl Given<'_> {
    pub(super) fn activity(
        &self,
        activity: &Activity,
        slot: Slot,
        held: &[(TaskId, Generated, Held)],
    ) -> Result<Task, Vec<Misfit>> {
        let id = TaskId::new(activity.id.get()).ok_or_else(|| vec![Misfit::Numbers])?;
        let body = self.body(activity, slot).map_err(|wrong| vec![wrong])?;
        let gates = match &body {
            Body::Sequence(steps) => library::gates(steps),
            _ => Vec::new(),
        };
        let wrong = misfits(&self.setting.mission, activity, &gates);
        if !wrong.is_empty() {
            return Err(wrong);
        }
        let devices = self.devices(&gates);
        let parameters = &self.setting.parameters;
        let mandatory = activity.priority >= parameters.mandatory_from;
        Ok(Task {
            name: activity.name.clone(),
            windows: vec![self.window(slot.start, self.closes(activity, slot))],
            cutoff: self.at(self.cutoff(activity, slot, mandatory)),
            duration: match body {
                Body::Hold => hold_length(slot),
                _ => duration(slot.length()),
            },
            categories: activity.resources,
            priority: self.priority(activity),
            peak_draw: activity.peak.saturating_sub(devices),
            average_draw: activity.marginal.saturating_sub(devices),
            data: u64::try_from(activity.data.get()).unwrap_or(0),
            preemption: if activity.pausable {
                Preemption::Pause
            } else {
                Preemption::Kill { grace: Duration::ZERO }
            },
            overrun: match activity.kind {
                // It has a grace first, at the end of which is its cutoff.
                Kind::Expanding { .. } => Overrun::Report,
                _ if mandatory => Overrun::Report,
                _ => Overrun::Abort,
            },
            after: self.after(activity, slot, held),
            gates,
            mandatory,
            ..Task::new(id, body)
        })
    }

    /// What it runs. An expanding one is told to end at its planned end: no
    /// later command of its sequence is issued.
    fn body(&self, activity: &Activity, slot: Slot) -> Result<Body, Misfit> {
        let Some(name) = &activity.sequence else { return Ok(Body::Hold) };
        let steps = self.setting.library.steps(name);
        let steps = steps.ok_or_else(|| Misfit::Sequence(activity.id, name.clone()))?;
        let expands = matches!(activity.kind, Kind::Expanding { .. });
        let until = duration(slot.length());
        let issued = |step: &&Step| !expands || step.offset <= until;
        Ok(Body::Sequence(steps.iter().filter(issued).cloned().collect()))
    }

    /// Its range, and what a device that is still made safe may cost; and while
    /// the computer is planned to be up: when that lets go of its draw, whoever
    /// waits for power would have it.
    fn closes(&self, activity: &Activity, slot: Slot) -> Time {
        let range = activity.starts.get(slot.range);
        let last = range.map_or(slot.start, |range| range.to.max(slot.start));
        let tolerance = self.setting.parameters.handover_tolerance;
        let up = self.phase_of(slot).map_or(Time::new(i64::MAX), |phase| lets_go(phase.down));
        // Nothing is so short that it could not be started.
        let soon = slot.start.after(tolerance).min(slot.end);
        last.after(tolerance).min(up).max(soon)
    }

    /// The phase in which the computer is up for it: one that is late for it,
    /// too. What takes no time needs none.
    pub(super) fn phase_of(&self, slot: Slot) -> Option<&AwakePhase> {
        let mut phases = self.timed.awake.iter().filter(|_| slot.start < slot.end);
        phases.find(|phase| slot.start < phase.down)
    }

    /// The task that wakes the computer for this phase, if it is to come.
    pub(super) fn wakes(
        phase: &AwakePhase,
        held: &[(TaskId, Generated, Held)],
    ) -> Option<Dependency> {
        let wakes = |what: &Generated| matches!(what, Generated::Wakeup(up) if *up == phase.up);
        let task = held.iter().find(|(_, what, _)| wakes(what)).map(|(id, ..)| *id)?;
        Some(Dependency { task, status: TaskStatus::Succeeded })
    }

    fn cutoff(&self, activity: &Activity, slot: Slot, mandatory: bool) -> Time {
        let end = self.setting.plan.end;
        let cutoff = activity.starts.get(slot.range).map_or(end, |range| range.cutoff.min(end));
        match activity.kind {
            Kind::Expanding { .. } if !mandatory => {
                cutoff.min(slot.end.after(self.setting.parameters.expansion_grace))
            }
            // What may be late by the tolerance ends as late.
            _ => cutoff,
        }
    }

    /// What must be over first. A prior that has ended agrees already, or the
    /// planner would not have it here.
    fn after(
        &self,
        activity: &Activity,
        slot: Slot,
        held: &[(TaskId, Generated, Held)],
    ) -> Vec<Dependency> {
        let priors = activity.after.iter().filter_map(|prior| self.prior(prior));
        let heating = activity.zones.iter().filter_map(|zone| {
            let of_zone = held.iter().filter_map(|(id, what, _)| match what {
                Generated::Heating(name, end) if name == zone => Some((*end, *id)),
                _ => None,
            });
            let last = of_zone.filter(|(end, _)| *end <= slot.start).max();
            last.map(|(_, task)| Dependency { task, status: TaskStatus::Succeeded })
        });
        let mut after: Vec<_> = priors.collect();
        let woken = self.phase_of(slot).and_then(|phase| Self::wakes(phase, held));
        for one in heating.chain(woken) {
            if !after.contains(&one) {
                after.push(one);
            }
        }
        after
    }

    /// The planner counts on success. A task waits for one status, and so for
    /// the widest one that the plan allows; where that is narrower than what the
    /// plan says, a new plan brings the activity back.
    fn prior(&self, prior: &Prior) -> Option<Dependency> {
        let at = self.setting.plan.activities.iter().position(|one| one.id == prior.prior)?;
        let fate = &self.timed.rows.get(at)?.fate;
        if !matches!(fate, Fate::Scheduled(_) | Fate::Running(_)) {
            return None;
        }
        let allows = |outcome| prior.statuses.iter().any(|status| status.includes(outcome));
        let status = match (allows(Outcome::Failed), allows(Outcome::Aborted)) {
            (true, true) => TaskStatus::Finished,
            (true, false) => TaskStatus::Completed,
            (false, _) => TaskStatus::Succeeded,
        };
        Some(Dependency { task: TaskId::new(prior.prior.get())?, status })
    }
}

/// What holds for the computer ends a little before its planned end.
const fn lets_go(down: Time) -> Time {
    let early = LATENESS.as_micros().div_ceil(1_000).cast_signed();
    down.before(Span::new(early.saturating_add(1)))
}

/// Whether the mission has these gates, and the plan counts their devices.
pub(super) fn misfits(mission: &Mission, activity: &Activity, gates: &[String]) -> Vec<Misfit> {
    let unknown = gates.iter().filter(|gate| !mission.devices.iter().any(|one| one.name == **gate));
    let mut wrong: Vec<_> = unknown.map(|gate| Misfit::Gate(activity.id, gate.clone())).collect();
    if gates.len() > MOST_GATES {
        wrong.push(Misfit::Gates(activity.id, gates.len()));
    }
    let more = devices(mission, gates).saturating_sub(activity.peak);
    if !more.is_zero() {
        wrong.push(Misfit::Peak(activity.id, more.get()));
    }
    wrong
}
