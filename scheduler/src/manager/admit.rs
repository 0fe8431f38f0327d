//! Tasks come into the schedule: all of a load, or none.

use crate::manager::demand::Demand;
use crate::manager::entry::{Entry, Place, Run};
use crate::manager::point::{Point, Present, to_instant, to_wall};
use crate::manager::step::Step;
use crate::manager::{Action, Addition, Manager, Note, Record};
use crate::task::{Task, TaskId};

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
        let mut added = Vec::with_capacity(tasks.len());
        for task in tasks {
            added.push(self.accept(task));
        }
        for index in &added {
            let is_needed = |entry: &Entry| self.manager.needed.contains_key(&entry.task.id);
            if self.entry(*index).is_some_and(is_needed) {
                self.make_clean_up(*index);
            }
            self.depend(*index);
        }
        if !added.is_empty() {
            self.act(Action::Sync);
        }
        for index in added {
            self.admit(index);
        }
        Ok(())
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
        if let Some(cleanup) = task.cleanup {
            *self.manager.needed.entry(cleanup).or_default() += 1;
        }
        let class = self.manager.classes.join(Demand::of(&task, &self.manager.mission));
        let entry = Entry {
            gone: Vec::new(),
            satisfied: vec![false; task.after.len()],
            task,
            load,
            position,
            accepted,
            class,
            current: 0,
            next: 0,
            back: 0,
            place: Place::Away,
            arrival: accepted.elapsed,
            due: Point::elapsed(accepted.elapsed),
            attempts: 0,
            failures: 0,
            saved: false,
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
        let index = self.manager.entries.insert(entry);
        self.manager.by_id.insert(id, index);
        self.manager.order.insert(position, index);
        self.manager.open = self.manager.open.saturating_add(1);
        index
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
        if let Some(why) = self.look_back(index) {
            return self.never_runs(index, why);
        }
        if !cleans_up {
            self.begin(index, number);
        }
    }

    /// Priors that have ended before, or are gone. Answers why the task can never
    /// run, if that follows.
    pub(crate) fn look_back(&mut self, index: u32) -> Option<String> {
        let entry = self.entry(index)?;
        for (number, after) in entry.task.after.clone().into_iter().enumerate() {
            let is_satisfied = |entry: &Entry| entry.satisfied.get(number) == Some(&true);
            if self.entry(index).is_some_and(is_satisfied) {
                continue;
            }
            let prior = self.manager.by_id.get(&after.task).and_then(|prior| self.entry(*prior));
            // A routine one that was removed is kept by the journal for its outcome.
            let is_gone = |prior: &&Entry| prior.place == Place::Over && prior.is_routine();
            let Some(prior) = prior.filter(|prior| !is_gone(prior)) else {
                return Some(gone(after.task));
            };
            if prior.place != Place::Over {
                continue;
            }
            if !prior.last.is_some_and(|outcome| after.status.includes(outcome)) {
                return Some(format!("{} has ended otherwise", after.task));
            }
            let entry = self.entry_mut(index);
            if let Some(satisfied) = entry.and_then(|entry| entry.satisfied.get_mut(number)) {
                *satisfied = true;
            }
        }
        None
    }
}

/// Why nobody who waits for an outcome of this task will run.
pub(crate) fn gone(prior: TaskId) -> String {
    format!("{prior} was taken out of the schedule")
}

impl Manager {
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
}
