//! A new timed plan, as what changes in the schedule.

use std::collections::{BTreeMap, BTreeSet};

use faregate_agents::Categories;
use faregate_scheduler::manager::{Addition, Telecommand};
use faregate_scheduler::task::{Task, TaskId, When};

use super::{Director, Live};
use crate::tasks::engines;
use crate::tasks::generated::Generated;
use crate::tasks::translate::Given;
use crate::tasks::{Epoch, Misfit};
use crate::timed::{Fate, Reason, TimedPlan};
use crate::units::Time;

impl Director {
    /// Executes this timed plan from now on. What runs is left alone, and so is
    /// what the present plan starts within the commit window.
    ///
    /// # Errors
    /// What keeps it from becoming tasks: the present plan goes on.
    pub fn adopt(&mut self, timed: TimedPlan) -> Result<(), Vec<Misfit>> {
        let mut numbers = self.numbers.clone();
        let (runs, given) = (self.engines(true), self.engines(false));
        let tasks = Given {
            setting: &self.setting,
            windows: &self.state.windows,
            timed: &timed,
            now: self.state.now,
            runs: &runs,
            given: &given,
        }
        .tasks(&mut numbers)?;
        self.numbers = numbers;
        self.timed = timed;
        self.planned_at = self.state.now;
        self.wishes.clear();
        self.again_at = None;
        self.change_to(tasks);
        Ok(())
    }

    /// The timed plan that a new one is made from: what waits for its tickets
    /// begins now, and not in the past. What needs a zone that is cold does not
    /// begin before that is heated again, be it committed or not.
    #[must_use]
    pub fn incumbent(&self) -> TimedPlan {
        let mut timed = self.timed.clone();
        for row in &mut timed.rows {
            let Fate::Scheduled(slot) = &mut row.fate else { continue };
            let Some(id) = TaskId::new(row.id.get()).filter(|id| self.waits(*id)) else { continue };
            if slot.start < self.state.now {
                slot.end = self.state.now.after(slot.length());
                slot.start = self.state.now;
            }
            if self.activity(id).is_some_and(|one| self.uses_what_is_cold(one)) {
                row.fate = Fate::Out(Reason::NoRangeLeft);
            }
        }
        timed
    }

    pub(super) fn waits(&self, id: TaskId) -> bool {
        self.live.get(&id).is_some_and(|live| !live.started)
    }

    /// Engines of what has started, or has not.
    pub(super) fn engines(&self, started: bool) -> BTreeMap<TaskId, Categories> {
        let count = self.setting.parameters.engines;
        let all = engines::all(&self.setting.mission, count).unwrap_or_default();
        let all = all.into_iter().fold(Categories::NONE, Categories::union);
        let live = self.live.iter().filter(|(_, live)| live.started == started);
        let has = live.map(|(id, live)| (*id, live.task.categories.shared(all)));
        has.filter(|(_, has)| !has.is_empty()).collect()
    }

    fn change_to(&mut self, tasks: Vec<Task>) {
        let mut wanted: BTreeMap<TaskId, Task> =
            tasks.iter().map(|task| (task.id, task.clone())).collect();
        let mut removed = BTreeSet::new();
        let mut moved = Vec::new();
        for (id, live) in &self.live {
            match wanted.get(id) {
                // A shutdown is not called back.
                None if live.started && (self.is_activity(*id) || self.is_shutdown(*id)) => {}
                None => {
                    removed.insert(*id);
                }
                Some(_) if live.started => {}
                Some(new) if self.stays(&live.task, new) => {}
                Some(new) if self.waits_alike(&live.task, new) && alike(&live.task, new) => {
                    moved.push(*id);
                }
                Some(_) => {
                    removed.insert(*id);
                }
            }
        }
        self.with_dependants(&mut removed);
        moved.retain(|id| !removed.contains(id));
        self.remove(removed);
        for id in &moved {
            self.move_to(*id, &wanted);
        }
        wanted.retain(|id, _| !self.live.contains_key(id));
        // In the order of the plan, which decides among equals.
        self.add(tasks.into_iter().filter(|task| wanted.contains_key(&task.id)).collect());
    }

    /// What depends on something that leaves the schedule leaves it, too, and
    /// comes in again.
    pub(super) fn with_dependants(&self, removed: &mut BTreeSet<TaskId>) {
        loop {
            let lost = |live: &Live| live.task.after.iter().any(|on| removed.contains(&on.task));
            let more: Vec<_> = self
                .live
                .iter()
                .filter(|(id, live)| !live.started && !removed.contains(id) && lost(live))
                .map(|(id, _)| *id)
                .collect();
            if more.is_empty() {
                return;
            }
            removed.extend(more);
        }
    }

    /// Dependants first: who loses what it waits for is taken out by the manager
    /// itself. One telecommand for each: one that is over by now is refused
    /// alone.
    pub(super) fn remove(&mut self, mut removed: BTreeSet<TaskId>) {
        while !removed.is_empty() {
            let live = removed.iter().filter_map(|id| self.live.get(id));
            let priors: BTreeSet<_> =
                live.flat_map(|live| live.task.after.iter().map(|on| on.task)).collect();
            let (now, later): (BTreeSet<_>, _) =
                removed.into_iter().partition(|id| !priors.contains(id));
            for id in &now {
                let live = self.live.remove(id);
                self.leaving.extend(live.map(|live| (*id, live)));
                self.held.remove(id);
                self.early.remove(id);
                self.orders.push(Telecommand::Remove(vec![*id]));
            }
            // Nothing comes after itself: the planner plans no circle.
            removed = if now.is_empty() { BTreeSet::new() } else { later };
        }
    }

    fn move_to(&mut self, id: TaskId, wanted: &BTreeMap<TaskId, Task>) {
        let Some((live, new)) = self.live.get_mut(&id).zip(wanted.get(&id)) else { return };
        live.task.windows.clone_from(&new.windows);
        live.closes = closes(self.setting.epoch, new);
        self.orders.push(Telecommand::SetWindows(id, new.windows.clone()));
    }

    fn add(&mut self, tasks: Vec<Task>) {
        if tasks.is_empty() {
            return;
        }
        for task in &tasks {
            let closes = closes(self.setting.epoch, task);
            let live = Live { task: task.clone(), closes, started: false };
            self.leaving.remove(&task.id);
            self.live.insert(task.id, live);
        }
        let additions = tasks.into_iter().map(|task| Addition { task }).collect();
        self.orders.push(Telecommand::Add(additions));
    }

    /// Whether a task that has not started need not be touched. What is due
    /// already begins now in the new plan.
    fn stays(&self, old: &Task, new: &Task) -> bool {
        let now = self.state.now;
        let epoch = self.setting.epoch;
        let start = |task| start_of(epoch, task).max(now);
        let is_same_time = start(old) == start(new) && closes(epoch, old) == closes(epoch, new);
        let is_soon = start(new) < now.after(self.setting.parameters.commit);
        let is_same = old.categories == new.categories
            && (is_soon || (self.waits_alike(old, new) && alike(old, new)));
        is_same_time && is_same
    }

    /// Whether it waits for the same: what it has waited for is over.
    fn waits_alike(&self, old: &Task, new: &Task) -> bool {
        let open = old.after.iter().filter(|on| self.live.contains_key(&on.task));
        open.eq(&new.after)
    }

    pub(super) fn is_activity(&self, id: TaskId) -> bool {
        self.activity(id).is_some()
    }

    fn is_shutdown(&self, id: TaskId) -> bool {
        matches!(self.numbers.what(id), Some(Generated::Shutdown(_)))
    }
}

pub(super) fn start_of(epoch: Epoch, task: &Task) -> Time {
    match task.windows.first().map(|window| window.opens) {
        Some(When::At(at)) => epoch.time(at),
        _ => Time::ZERO,
    }
}

fn closes(epoch: Epoch, task: &Task) -> Time {
    match task.windows.first().map(|window| window.closes) {
        Some(When::At(at)) => epoch.time(at),
        _ => Time::new(i64::MAX),
    }
}

fn alike(old: &Task, new: &Task) -> bool {
    Task { windows: Vec::new(), after: Vec::new(), ..old.clone() }
        == Task { windows: Vec::new(), after: Vec::new(), ..new.clone() }
}
