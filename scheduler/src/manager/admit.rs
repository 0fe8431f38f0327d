//! Tasks come into the schedule: all of a load, or none.

use std::collections::{HashMap, HashSet};

use crate::manager::demand::Demand;
use crate::manager::entry::{Entry, Place, Run};
use crate::manager::limits::MAX_DEVICES;
use crate::manager::point::{Point, Present, to_instant, to_wall};
use crate::manager::step::Step;
use crate::manager::{Action, Addition, Manager, Note, Record};
use crate::task::{Body, BuiltIn, Preemption, Task, TaskId};

/// What a task that is put into the schedule is, beside itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Admission {
    pub(crate) load: u32,
    pub(crate) position: u64,
    pub(crate) accepted: Present,
    pub(crate) held: bool,
}

impl Step<'_> {
    /// Adds these tasks.
    ///
    /// # Errors
    /// What is wrong with them, all of it. Nothing has changed then.
    pub(crate) fn add(&mut self, additions: Vec<Addition>) -> Result<(), String> {
        let tasks: Vec<Task> = additions.into_iter().map(|addition| addition.task).collect();
        let defects = self.manager.defects(&tasks);
        if !defects.is_empty() {
            return Err(defects.join("; "));
        }
        let cleaning = self.cleaning(&tasks);
        let mut added = Vec::with_capacity(tasks.len());
        for task in tasks {
            added.push(self.accept(task));
        }
        if !added.is_empty() {
            self.act(Action::Sync);
        }
        for id in cleaning {
            if let Some(index) = self.manager.by_id.get(&id).copied() {
                self.make_clean_up(index);
            }
        }
        for index in &added {
            self.depend(*index);
        }
        for index in added {
            self.admit(index);
        }
        Ok(())
    }

    /// Who is named as somebody's cleanup, by these tasks or by those before.
    fn cleaning(&self, tasks: &[Task]) -> HashSet<TaskId> {
        tasks.iter().filter_map(|task| task.cleanup).collect()
    }

    fn accept(&mut self, task: Task) -> u32 {
        let load = self.replace_ended(task.id);
        let position = self.manager.next_position;
        self.manager.next_position = position.saturating_add(1);
        let accepted = self.now;
        self.write(Record::Accepted {
            task: Box::new(task.clone()),
            load,
            position,
            at: to_instant(accepted.elapsed),
            wall: to_wall(accepted.wall),
        });
        self.note(Note::Accepted(task.id));
        self.insert(task, Admission { load, position, accepted, held: false })
    }

    /// The number of tasks of this id that were there before. The last of them
    /// has ended, and makes room.
    fn replace_ended(&mut self, id: TaskId) -> u32 {
        let Some(index) = self.manager.by_id.get(&id).copied() else {
            return self.manager.loads.get(&id).copied().unwrap_or(0);
        };
        let load = self.entry(index).map_or(0, |entry| entry.load.saturating_add(1));
        self.take_out(index);
        load
    }

    /// Puts a task where it can be found. Nothing happens to it yet.
    pub(crate) fn insert(&mut self, task: Task, admission: Admission) -> u32 {
        let Admission { load, position, accepted, held } = admission;
        let id = task.id;
        let class = self.manager.classes.join(Demand::of(&task, &self.manager.mission));
        let entry = Entry {
            satisfied: vec![false; task.after.len()],
            task,
            load,
            position,
            accepted,
            class,
            current: 0,
            next: 0,
            place: Place::Away,
            arrival: accepted.elapsed,
            due: Point::elapsed(accepted.elapsed),
            attempts: 0,
            failures: 0,
            held,
            removed: false,
            armed: false,
            cleans_up: false,
            misses: None,
            last: None,
            told: None,
            run: Run::new(),
            timers: Default::default(),
        };
        let index = self.manager.store(entry);
        self.manager.by_id.insert(id, index);
        self.manager.order.insert(position, index);
        self.manager.loads.insert(id, load.saturating_add(1));
        self.manager.open = self.manager.open.saturating_add(1);
        index
    }

    /// Makes a task one that waits for the failure of another one.
    pub(crate) fn make_clean_up(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index).filter(|entry| !entry.cleans_up) else { return };
        entry.cleans_up = true;
        self.manager.open = self.manager.open.saturating_sub(1);
    }

    /// Ties a task to those that it depends on.
    pub(crate) fn depend(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        let priors: Vec<_> = entry.task.after.iter().map(|after| after.task).collect();
        for (number, prior) in priors.into_iter().enumerate() {
            self.manager.dependants.entry(prior).or_default().push((index, number));
        }
    }

    /// Lets a task that was put into the schedule have its first occurrence.
    fn admit(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        if let Some(why) = self.manager.can_never_run(entry) {
            return self.never_runs(index, why);
        }
        let (cleans_up, routine) = (entry.cleans_up, entry.is_routine());
        let number = if routine { entry.first_number(self.now) } else { 0 };
        if !self.look_back(index) {
            return;
        }
        if !cleans_up {
            self.begin(index, number);
        }
    }

    /// Priors that have ended before. Answers whether the task is still there.
    pub(crate) fn look_back(&mut self, index: u32) -> bool {
        let Some(entry) = self.entry(index) else { return false };
        for (number, after) in entry.task.after.clone().into_iter().enumerate() {
            let prior = self.manager.by_id.get(&after.task).and_then(|prior| self.entry(*prior));
            let Some(outcome) =
                prior.filter(|prior| prior.place == Place::Over).and_then(|prior| prior.last)
            else {
                continue;
            };
            if !after.status.includes(outcome) {
                self.never_runs(index, format!("{} has ended otherwise", after.task));
                return false;
            }
            let entry = self.entry_mut(index);
            if let Some(satisfied) = entry.and_then(|entry| entry.satisfied.get_mut(number)) {
                *satisfied = true;
            }
        }
        true
    }
}

impl Manager {
    fn store(&mut self, entry: Entry) -> u32 {
        if let Some(index) = self.free.pop() {
            if let Some(place) =
                usize::try_from(index).ok().and_then(|index| self.entries.get_mut(index))
            {
                *place = Some(entry);
            }
            return index;
        }
        self.entries.push(Some(entry));
        u32::try_from(self.entries.len().saturating_sub(1)).unwrap_or(u32::MAX)
    }

    /// Why such a task could not run even alone.
    pub(crate) fn can_never_run(&self, entry: &Entry) -> Option<String> {
        use crate::manager::ledger::{Part, Short};
        let demand = self.classes.demand(entry.class);
        let what = match self.ledger().short(&demand, Part::All, &self.installed)? {
            Short::Draw(short) => {
                let short = faregate_tickets::amount::Milliwatts::new(short);
                format!("it draws {short} more than the supply")
            }
            Short::Memory(short) => format!("it needs {short} bytes of memory more than there are"),
            Short::Storage(short) => {
                format!("it needs {short} bytes of storage more than there are")
            }
            Short::Categories(_) | Short::Gates(_) => return None,
        };
        Some(what)
    }

    /// Everything that is wrong with these tasks, as an addition to what is
    /// there.
    fn defects(&self, tasks: &[Task]) -> Vec<String> {
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
        match there {
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
