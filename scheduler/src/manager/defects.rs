//! What is wrong with tasks that are to come into the schedule.

use std::collections::HashMap;

use crate::manager::Manager;
use crate::manager::entry::Place;
use crate::manager::limits::MAX_DEVICES;
use crate::task::{Body, BuiltIn, Preemption, Task, TaskId};

impl Manager {
    /// Everything that is wrong with these tasks, as an addition to what is
    /// there.
    pub(crate) fn defects(&self, tasks: &[Task]) -> Vec<String> {
        let mut defects = Vec::new();
        if self.mission.devices.len() > MAX_DEVICES {
            defects.push(format!("the mission has more than {MAX_DEVICES} devices"));
        }
        let mut seen: HashMap<TaskId, &Task> = HashMap::new();
        for task in tasks {
            if seen.insert(task.id, task).is_some() {
                defects.push(format!("{}: its id is there twice", task.id));
            }
        }
        for task in tasks {
            self.defects_of(task, &seen, &mut defects);
        }
        if let Some(id) = cycle(tasks, &seen) {
            defects.push(format!("{id}: it depends on itself, by way of others"));
        }
        defects
    }

    fn defects_of(&self, task: &Task, seen: &HashMap<TaskId, &Task>, defects: &mut Vec<String>) {
        let mut defect = |what: String| defects.push(format!("{}: {what}", task.id));
        let lives = |id: &TaskId| {
            self.by_id
                .get(id)
                .and_then(|index| self.entry(*index))
                .is_some_and(|entry| entry.place != Place::Over)
        };
        if lives(&task.id) {
            defect("its id is in use".into());
        }
        if task.windows.is_empty() {
            defect("it has no window".into());
        }
        if task.interval.is_some_and(|interval| interval.is_zero()) {
            defect("its interval is zero: give none, or a longer one".into());
        }
        if task.battery > 0 && !self.installed.battery {
            defect("it asks for a state of charge, and the mission has no battery".into());
        }
        for gate in &task.gates {
            if !self.mission.devices.iter().any(|device| device.name == *gate) {
                defect(format!("the mission has no device {gate}"));
            }
        }
        let known = |id: &TaskId| seen.contains_key(id) || self.by_id.contains_key(id);
        for after in &task.after {
            if !known(&after.task) {
                defect(format!("it depends on {}, which is not in the schedule", after.task));
            }
        }
        if let Some(cleanup) = task.cleanup {
            self.defects_of_cleanup(task, cleanup, seen, &mut defect);
        }
        if task.interval.is_some() && self.needed.contains_key(&task.id) {
            defect("a task in the schedule has it clean up, and it is a routine task".into());
        }
        let stoppable = matches!(task.body, Body::Function { .. });
        if stoppable && matches!(task.preemption, Preemption::Pause | Preemption::Kill { .. }) {
            defect("a function can only wait or be checkpointed".into());
        }
        if let Body::BuiltIn(BuiltIn::EnterMode(mode) | BuiltIn::LeaveMode(mode)) = &task.body
            && !self.mission.modes.iter().any(|spec| spec.name == *mode)
        {
            defect(format!("the mission has no mode {mode}"));
        }
    }

    fn defects_of_cleanup(
        &self,
        task: &Task,
        cleanup: TaskId,
        seen: &HashMap<TaskId, &Task>,
        defect: &mut impl FnMut(String),
    ) {
        if cleanup == task.id {
            return defect("it cleans up after itself".into());
        }
        if let Some(other) = seen.get(&cleanup) {
            if other.interval.is_some() {
                defect(format!("{cleanup} cleans up, and cannot be a routine task"));
            }
            return;
        }
        let there = self.by_id.get(&cleanup).and_then(|index| self.entry(*index));
        match there.filter(|entry| entry.place != Place::Over) {
            Some(entry) if entry.cleans_up => {}
            Some(_) => {
                defect(format!("{cleanup} is in the schedule by itself: it cannot clean up"))
            }
            None => defect(format!("{cleanup} is to clean up, and is not in the schedule")),
        }
    }
}

/// A task of these that depends on itself. (What was there before cannot depend
/// on them.)
fn cycle(tasks: &[Task], seen: &HashMap<TaskId, &Task>) -> Option<TaskId> {
    let mut waits_for: HashMap<TaskId, usize> = HashMap::new();
    let mut dependants: HashMap<TaskId, Vec<TaskId>> = HashMap::new();
    for task in tasks {
        let priors = task.after.iter().filter(|after| seen.contains_key(&after.task));
        for after in priors {
            *waits_for.entry(task.id).or_default() += 1;
            dependants.entry(after.task).or_default().push(task.id);
        }
    }
    let mut free: Vec<TaskId> =
        tasks.iter().map(|task| task.id).filter(|id| !waits_for.contains_key(id)).collect();
    while let Some(id) = free.pop() {
        for dependant in dependants.remove(&id).unwrap_or_default() {
            let Some(count) = waits_for.get_mut(&dependant) else { continue };
            *count = count.saturating_sub(1);
            if *count == 0 {
                waits_for.remove(&dependant);
                free.push(dependant);
            }
        }
    }
    waits_for.into_keys().min()
}
