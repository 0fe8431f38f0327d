//! What the manager is told to do.

use crate::manager::entry::{Asked, Place};
use crate::manager::step::Step;
use crate::manager::timers::Kind;
use crate::manager::{Action, Note, Record, Reply, Telecommand, TelecommandId};
use crate::task::{TaskId, TaskPriority, Window};

impl Step<'_> {
    /// Does it, or refuses; the answer comes when it is in the journal.
    pub(crate) fn telecommand(&mut self, id: TelecommandId, telecommand: Telecommand) {
        let done = match telecommand {
            Telecommand::Add(additions) => self.add(additions),
            Telecommand::Remove(ids) => self.remove(&ids),
            Telecommand::SetPriority(id, priority) => self.set_priority(id, priority),
            Telecommand::SetWindows(id, windows) => self.set_windows(id, windows),
            Telecommand::Clear { all } => {
                self.clear(all, None);
                Ok(())
            }
            Telecommand::Hold(id) => self.hold(id),
            Telecommand::Resume(id) => self.let_go(id),
            Telecommand::EnterMode(name) => self.enter_mode(&name),
            Telecommand::LeaveMode(name) => self.leave_mode(&name),
            Telecommand::ShutDown => {
                self.shut_down();
                Ok(())
            }
        };
        let reply = done.map_or_else(Reply::Refused, |()| Reply::Done);
        self.act(Action::Answer { id, reply });
    }

    /// The task of this id that is not over.
    fn find(&self, id: TaskId) -> Result<u32, String> {
        let index = self.manager.by_id.get(&id).copied();
        let lives = |index: &u32| self.entry(*index).is_some_and(|e| e.place != Place::Over);
        index.filter(lives).ok_or_else(|| missing(id))
    }

    /// Removes tasks, all or none. One that is over is there until then.
    pub(crate) fn remove(&mut self, ids: &[TaskId]) -> Result<(), String> {
        let there = |id: &TaskId| self.manager.by_id.get(id).copied().ok_or_else(|| missing(*id));
        let indexes = ids.iter().map(there).collect::<Result<Vec<_>, _>>()?;
        for index in indexes {
            self.discard(index, "removed");
        }
        self.act(Action::Sync);
        Ok(())
    }

    /// Takes a task out; a body is ended first.
    fn discard(&mut self, index: u32, why: &str) {
        let Some(entry) = self.entry(index) else { return };
        let id = entry.task.id;
        if entry.place == Place::Over {
            return self.take_out(index);
        }
        if entry.run.has_body() {
            self.leaves(index);
            return self.abort(index, why);
        }
        self.note(Note::Removed(id));
        self.take_out(index);
    }

    /// It goes when its body has ended, whoever is the manager then.
    fn leaves(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index).filter(|entry| !entry.removed) else { return };
        entry.removed = true;
        let (task, load) = (entry.task.id, entry.load);
        self.write(Record::Leaving { task, load });
    }

    /// Drops what is pending; with `all` ends what runs, too. The attempt that
    /// asks for it stays.
    pub(crate) fn clear(&mut self, all: bool, by: Option<u32>) {
        let indexes: Vec<u32> = self.manager.order.values().copied().collect();
        let stays = |index: &u32| self.entry(*index).filter(|entry| !all && entry.run.has_body());
        // Who cleans up after those that stay, stays.
        let cleaning: Vec<TaskId> =
            indexes.iter().filter_map(stays).filter_map(|entry| entry.task.cleanup).collect();
        for index in indexes {
            let Some(entry) = self.entry(index) else { continue };
            if entry.is_resting() && cleaning.contains(&entry.task.id) {
                continue;
            }
            if Some(index) == by {
                if entry.is_routine() {
                    self.leaves(index);
                }
            } else if all || !entry.run.has_body() {
                self.discard(index, "cleared");
            } else {
                // What runs goes on, and is not run again.
                self.leaves(index);
            }
        }
        self.act(Action::Sync);
    }

    fn set_priority(&mut self, id: TaskId, priority: TaskPriority) -> Result<(), String> {
        let index = self.find(id)?;
        let place = self.entry(index).map(|entry| entry.place);
        let has_body = self.entry(index).is_some_and(|entry| entry.run.has_body());
        if !has_body {
            self.unseat(index);
        }
        let Some(entry) = self.entry_mut(index) else { return Ok(()) };
        entry.task.priority = priority;
        entry.run.stale = has_body;
        if has_body {
            self.unblock();
        } else if place != Some(Place::Away) {
            self.enter(index);
        }
        self.changed(index);
        Ok(())
    }

    /// The agents do not hear of the new priority of tickets that are held. So
    /// whoever waits there asks anew, and names its victims.
    fn unblock(&mut self) {
        for index in self.manager.live.clone() {
            let Some(entry) = self.entry_mut(index) else { continue };
            entry.run.stale |= matches!(entry.run.asked, Asked::Blocked(_));
        }
    }

    /// The arrival of an occurrence that was due already stays.
    fn set_windows(&mut self, id: TaskId, windows: Vec<Window>) -> Result<(), String> {
        if windows.is_empty() {
            return Err(format!("{id} would have no window"));
        }
        let index = self.find(id)?;
        let now = self.now;
        let idle = self.entry(index).is_some_and(|entry| !entry.run.has_body());
        if idle {
            self.unseat(index);
        }
        let Some(entry) = self.entry_mut(index) else { return Ok(()) };
        let was_due = now.has_reached(entry.due);
        entry.task.windows = windows;
        let (due, routine) = (entry.due_of(entry.current), entry.is_routine());
        if !was_due || now.until(due) > 0 {
            entry.arrival = entry.accepted.on_elapsed(due);
        }
        let next = routine.then(|| entry.due_of(entry.next));
        self.set_timer(index, Kind::Next, next);
        self.changed(index);
        if idle && self.entry(index).is_some_and(|entry| !entry.is_resting()) {
            self.seat(index, None);
        }
        Ok(())
    }

    fn hold(&mut self, id: TaskId) -> Result<(), String> {
        let index = self.find(id)?;
        let Some(entry) = self.entry_mut(index) else { return Ok(()) };
        entry.held = true;
        if !entry.run.has_body() {
            self.unseat(index);
        }
        self.changed(index);
        Ok(())
    }

    fn let_go(&mut self, id: TaskId) -> Result<(), String> {
        let index = self.find(id)?;
        let Some(entry) = self.entry_mut(index) else { return Ok(()) };
        if !core::mem::replace(&mut entry.held, false) {
            return Err(format!("{id} is not held"));
        }
        let waits = entry.place == Place::Away && !entry.run.has_body() && !entry.is_resting();
        if waits && entry.is_ready() {
            self.enter(index);
        }
        self.changed(index);
        Ok(())
    }

    fn changed(&mut self, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        let (task, held) = (Box::new(entry.task.clone()), entry.held);
        self.write(Record::Changed { task, held });
        self.act(Action::Sync);
    }

    /// Everything that runs ends, and nothing starts any more.
    fn shut_down(&mut self) {
        self.manager.shutting_down = true;
        for index in self.manager.live.clone() {
            let Some(entry) = self.entry(index) else { continue };
            if entry.run.has_body() {
                self.abort(index, "the manager is shut down");
            } else {
                self.unseat(index);
                self.seat(index, None);
            }
        }
        let all: Vec<u32> = self.manager.order.values().copied().collect();
        for index in all {
            self.tell_missed(index);
        }
    }
}

fn missing(id: TaskId) -> String {
    format!("{id} is not in the schedule")
}
