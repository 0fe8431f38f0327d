//! A timed plan as tasks.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::manager::limits::LATENESS;
use faregate_scheduler::task::{
    Body, Dependency, Overrun, Preemption, Task, TaskId, TaskPriority, When, Window as TaskWindow,
};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

use super::engines::{self, Engines, Wish};
use super::generated::{Generated, Numbers};
use super::{Misfit, Setting};
use crate::parameters::Load;
use crate::state::Window;
use crate::timed::{Fate, Slot, TimedPlan};
use crate::units::{Span, Time};

/// The tasks of a timed plan from now on: those of its activities that have not
/// started, in the plan's order, then those that only hold.
///
/// Tasks that only hold end a little earlier than planned: a tenth of their
/// time, and 100 ms at the most. What begins when they end would find their
/// draw still taken where the host is late, and take it from somebody else.
///
/// # Errors
/// Everything that keeps activities from becoming tasks.
pub fn tasks(
    setting: &Setting,
    windows: &[Window],
    timed: &TimedPlan,
    now: Time,
) -> Result<Vec<Task>, Vec<Misfit>> {
    let none = BTreeMap::new();
    let given = Given { setting, windows, timed, now, runs: &none, given: &none };
    given.tasks(&mut Numbers::above(&setting.plan))
}

/// What is translated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Given<'a> {
    pub(super) setting: &'a Setting,
    pub(super) windows: &'a [Window],
    pub(super) timed: &'a TimedPlan,
    pub(super) now: Time,
    /// Engines of what runs.
    pub(super) runs: &'a BTreeMap<TaskId, Categories>,
    /// Engines that were given to what does not run yet.
    pub(super) given: &'a BTreeMap<TaskId, Categories>,
}

/// Something that is only held.
#[derive(Clone, Debug)]
pub(super) struct Held {
    pub(super) slot: Slot,
    pub(super) draw: Load,
    /// None: nobody takes it.
    pub(super) priority: Option<TaskPriority>,
    pub(super) categories: Categories,
    pub(super) engines: usize,
    pub(super) gates: Vec<String>,
}

impl Given<'_> {
    pub(super) fn tasks(&self, numbers: &mut Numbers) -> Result<Vec<Task>, Vec<Misfit>> {
        let all = engines::all(&self.setting.mission, self.setting.parameters.engines)?;
        let mut held = Vec::new();
        for (what, one) in self.generated() {
            held.push((numbers.id(&what)?, what, one));
        }
        let wishes = self.wishes(&held);
        let engines = Engines::assign(&all, &wishes, self.runs, self.given);
        let (mut tasks, mut wrong) = (Vec::new(), Vec::new());
        for (activity, row) in self.setting.plan.activities.iter().zip(&self.timed.rows) {
            let Fate::Scheduled(slot) = row.fate else { continue };
            match self.activity(activity, slot, &held) {
                Ok(task) => tasks.push(with_engines(task, &engines)),
                Err(found) => wrong.extend(found),
            }
        }
        if !wrong.is_empty() {
            return Err(wrong);
        }
        let after: Vec<_> = held.iter().map(|(_, what, _)| self.woken(what, &held)).collect();
        let held = held.into_iter().zip(after).map(|((id, what, one), after)| {
            let after = after.into_iter().collect();
            with_engines(Task { after, ..self.hold(id, &what, one) }, &engines)
        });
        tasks.extend(held);
        Ok(tasks)
    }

    fn wishes(&self, held: &[(TaskId, Generated, Held)]) -> Vec<Wish> {
        let activities = self.slots().filter_map(|(activity, slot)| {
            let count = usize::try_from(activity.engines).unwrap_or(usize::MAX);
            Some(Wish { id: TaskId::new(activity.id.get())?, slot, count })
        });
        let held =
            held.iter().map(|(id, _, one)| Wish { id: *id, slot: one.slot, count: one.engines });
        activities.chain(held).collect()
    }

    /// A computer that was not woken is not up, and not shut down.
    fn woken(&self, what: &Generated, held: &[(TaskId, Generated, Held)]) -> Option<Dependency> {
        let phase = self.timed.awake.iter().find(|phase| match what {
            Generated::Awake(down) => phase.down == *down,
            Generated::Shutdown(asleep) => phase.asleep == *asleep,
            Generated::Wakeup(_) | Generated::Heating(..) | Generated::Window(..) => false,
        });
        phase.and_then(|phase| Self::wakes(phase, held))
    }

    fn hold(&self, id: TaskId, what: &Generated, held: Held) -> Task {
        let allowed = self.setting.parameters.handover_tolerance;
        let never = Preemption::Wait;
        // One that was taken is not begun again: a new plan says what is.
        let taken = Preemption::Kill { grace: Duration::ZERO };
        let devices = self.devices(&held.gates);
        Task {
            name: Some(words(what)),
            windows: vec![self.window(held.slot.start, held.tolerance(allowed))],
            duration: hold_length(held.slot),
            categories: held.categories,
            priority: held.priority.unwrap_or(TaskPriority::TOP),
            peak_draw: held.draw.peak.saturating_sub(devices),
            average_draw: held.draw.marginal.saturating_sub(devices),
            preemption: if held.priority.is_none() { never } else { taken },
            overrun: Overrun::Report,
            gates: held.gates,
            mandatory: true,
            ..Task::new(id, Body::Hold)
        }
    }

    pub(super) fn window(&self, opens: Time, closes: Time) -> TaskWindow {
        TaskWindow { opens: self.at(opens), closes: self.at(closes) }
    }

    pub(super) fn at(&self, time: Time) -> When {
        When::At(self.setting.epoch.wall(time))
    }

    pub(super) fn devices(&self, gates: &[String]) -> Milliwatts {
        devices(&self.setting.mission, gates)
    }
}

/// What devices draw at the agent that tasks' own draws are charged to.
pub(super) fn devices(mission: &Mission, gates: &[String]) -> Milliwatts {
    let Some(first) = mission.agents.first() else { return Milliwatts::ZERO };
    let mine = mission.devices.iter();
    let mine = mine.filter(|one| gates.contains(&one.name) && one.agent == first.name);
    mine.filter_map(|one| one.draw).fold(Milliwatts::ZERO, Milliwatts::saturating_add)
}

fn with_engines(mut task: Task, engines: &Engines<'_>) -> Task {
    if let Some(has) = engines.of.get(&task.id) {
        task.categories = task.categories.union(*has);
    }
    task
}

fn words(what: &Generated) -> String {
    match what {
        Generated::Wakeup(_) => "wakeup".into(),
        Generated::Awake(_) => "awake".into(),
        Generated::Shutdown(_) => "shutdown".into(),
        Generated::Heating(zone, _) => format!("heat {zone}"),
        Generated::Window(name, _) => format!("window {name}"),
    }
}

/// How long something is held.
pub(super) fn hold_length(slot: Slot) -> Duration {
    let length = duration(slot.length());
    let tenth = Duration::from_micros(length.as_micros() / 10);
    length.saturating_sub(LATENESS.min(tenth))
}

pub(super) fn duration(span: Span) -> Duration {
    Duration::from_millis(u64::try_from(span.get()).unwrap_or(0))
}
