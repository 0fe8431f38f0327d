//! Dependencies on what became of other tasks, and tasks that are gone.

use crate::manager::admit::gone;
use crate::manager::entry::{Entry, Place};
use crate::manager::limits::MOST_GONE;
use crate::manager::step::Step;
use crate::manager::{Note, Record};
use crate::task::{Outcome, TaskId};

impl Step<'_> {
    /// Who waits for this outcome. After the last one of a task, whoever waited
    /// for another one can never run.
    pub(crate) fn settle_dependants(&mut self, index: u32, outcome: Outcome, last: bool) {
        let Some(id) = self.entry(index).map(|entry| entry.task.id) else { return };
        let Some(dependants) = self.manager.dependants.get(&id) else { return };
        for (dependant, number) in dependants.clone() {
            self.settle(dependant, number, outcome, last);
        }
    }

    fn settle(&mut self, index: u32, number: usize, outcome: Outcome, last: bool) {
        let Some(entry) = self.entry_mut(index).filter(|entry| entry.place != Place::Over) else {
            return;
        };
        let Some(dependency) = entry.task.after.get(number).copied() else { return };
        let Some(satisfied) = entry.satisfied.get_mut(number) else { return };
        if dependency.status.includes(outcome) {
            let was_ready = core::mem::replace(satisfied, true);
            let waits = entry.place == Place::Away && !entry.run.has_body();
            if !was_ready && waits && entry.is_ready() && self.is_begun(index) {
                self.enter(index);
            }
        } else if last && !*satisfied && !entry.has_started() {
            let why = format!("{} has ended otherwise", dependency.task);
            self.never_runs(index, why);
        }
    }

    /// A task that cleans up has an occurrence only when it was started, and one
    /// of a journal only when it was put back.
    fn is_begun(&self, index: u32) -> bool {
        self.entry(index).is_some_and(|entry| entry.next > entry.current)
    }

    /// Outcomes of routine tasks satisfy each dependant once.
    pub(crate) fn spend_dependencies(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        let lasts = |id: TaskId| !entry.gone.contains(&id) && self.is_lasting(id);
        let again: Vec<bool> = entry.task.after.iter().map(|after| lasts(after.task)).collect();
        if let Some(entry) = self.entry_mut(index) {
            for (satisfied, lasting) in entry.satisfied.iter_mut().zip(again) {
                *satisfied &= lasting;
            }
        }
    }

    /// Whether the outcome of a task is its only one.
    fn is_lasting(&self, id: TaskId) -> bool {
        let entry = self.manager.by_id.get(&id).and_then(|index| self.entry(*index));
        entry.is_none_or(|entry| !entry.is_routine() && !entry.cleans_up)
    }

    /// The task can never run: before the next decision it is reported, and
    /// taken out of the schedule.
    pub(crate) fn never_runs(&mut self, index: u32, why: String) {
        let Some(position) = self.entry(index).map(|entry| entry.position) else { return };
        self.manager.doomed.push_back((index, position, why));
    }

    fn bury_one(&mut self, index: u32, why: String) {
        let Some(task) = self.entry(index).map(|entry| entry.task.id) else { return };
        self.note(Note::NeverRuns { task, why });
        self.take_out(index);
    }

    /// Tasks of which it became known that they can never run, or have nothing
    /// more to clean up. One can take others with it, in a chain as long as the
    /// schedule.
    pub(crate) fn bury(&mut self) {
        loop {
            if let Some((index, position, why)) = self.manager.doomed.pop_front() {
                let lives =
                    |entry: &Entry| entry.position == position && entry.place != Place::Over;
                if self.entry(index).is_some_and(lives) {
                    self.bury_one(index, why);
                }
            } else if let Some((index, position)) = self.manager.idle.pop_front() {
                self.retire(index, position);
            } else {
                return;
            }
        }
    }

    /// Takes a task out of the schedule, and with it those that wait for an
    /// outcome that it will not have.
    pub(crate) fn take_out(&mut self, index: u32) {
        self.tell_missed(index);
        self.unseat(index);
        let Some(entry) = self.entry(index) else { return };
        let (id, load, position, class) = (entry.task.id, entry.load, entry.position, entry.class);
        let ended = entry.place == Place::Over;
        let counts = !ended && !entry.cleans_up;
        let dependencies: Vec<TaskId> = entry.task.after.iter().map(|after| after.task).collect();
        self.write(Record::Removed { task: id, load });
        if !ended {
            self.needs_no_cleanup(index);
        }
        for kind in crate::manager::timers::EVERY {
            self.set_timer(index, kind, None);
        }
        for prior in dependencies {
            let Some(dependants) = self.manager.dependants.get_mut(&prior) else { continue };
            dependants.retain(|(dependant, _)| *dependant != index);
            if dependants.is_empty() {
                self.manager.dependants.remove(&prior);
            }
        }
        self.manager.classes.leave(class);
        self.manager.order.remove(&position);
        self.manager.by_id.remove(&id);
        self.manager.armed.retain(|armed| *armed != index);
        if counts {
            self.manager.open = self.manager.open.saturating_sub(1);
        }
        if ended {
            self.manager.ended.retain(|ended| *ended != index);
        }
        self.manager.entries.remove(index);
        self.remember_load(id, load.saturating_add(1));
        if !ended {
            self.leave_alone(id);
        }
    }

    fn remember_load(&mut self, id: TaskId, load: u32) {
        let manager = &mut *self.manager;
        manager.loads.insert(id, load);
        manager.gone.push_back((id, load));
        while manager.gone.len() > MOST_GONE
            && let Some((id, load)) = manager.gone.pop_front()
        {
            if manager.loads.get(&id) == Some(&load) {
                manager.loads.remove(&id);
            }
        }
    }

    /// Who waits for an outcome of a task that is gone.
    fn leave_alone(&mut self, id: TaskId) {
        for (dependant, number) in self.manager.dependants.get(&id).cloned().unwrap_or_default() {
            let Some(entry) = self.entry(dependant) else { continue };
            let satisfied = entry.satisfied.get(number).copied().unwrap_or(false);
            if entry.place == Place::Over || entry.has_started() {
                continue;
            }
            if !satisfied {
                self.never_runs(dependant, gone(id));
            } else if let Some(entry) = self.entry_mut(dependant) {
                entry.gone.push(id);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manager::limits::MOST_ENDED;
    use crate::manager::{Addition, Event, Manager, Telecommand, TelecommandId};
    use crate::mission::Mission;
    use crate::task::{Body, Dependency, Status, Task, When, Window};
    use crate::time::{Now, UnixTime};

    /// Two that are missed at once, of which the second one waits for that, and
    /// its cleanup.
    fn three(number: u32) -> Vec<Addition> {
        let [first, second] = [number, number + 1].map(|id| {
            let mut task = Task::new(TaskId::new(id).unwrap(), Body::Hold);
            let closes = When::At(UnixTime::from_secs(1));
            task.windows = vec![Window { opens: When::At(UnixTime::from_secs(1)), closes }];
            task
        });
        let after = vec![Dependency { task: first.id, status: Status::Missed }];
        let cleanup = Some(TaskId::new(number + 2).unwrap());
        let last = Task::new(TaskId::new(number + 2).unwrap(), Body::Hold);
        let second = Task { after, cleanup, ..second };
        [first, second, last].map(|task| Addition { task }).to_vec()
    }

    #[test]
    fn what_comes_and_goes_for_years_leaves_nothing_behind() {
        let mut manager = Manager::new(Mission::default());
        let now = Now { wall: UnixTime::from_secs(1_000_000), ..Now::default() };
        let mut actions = Vec::new();
        for number in (1..).step_by(3).take(2 * MOST_GONE / 3) {
            let telecommand = Telecommand::Add(three(number));
            let add = Event::Telecommand { id: TelecommandId(0), telecommand };
            manager.step(now, vec![add], &mut actions);
            actions.clear();
        }
        assert_eq!(manager.status().count(), MOST_ENDED);
        assert!(manager.dependants.len() <= MOST_ENDED, "{}", manager.dependants.len());
        assert_eq!((manager.loads.len(), manager.gone.len()), (MOST_GONE, MOST_GONE));
        assert!(manager.needed.is_empty() && manager.idle.is_empty() && manager.live.is_empty());
        assert_eq!(manager.by_id.len(), MOST_ENDED);
        assert!(manager.is_over());
    }
}
