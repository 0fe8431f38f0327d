//! What somebody who asks is told.

use crate::manager::entry::{Entry, Place, Stage};
use crate::manager::point::{Clock, Point, to_instant, to_wall};
use crate::manager::{Manager, Needs, Occurrence, State, TaskStatus, WaitsFor};
use crate::task::{Outcome, Preemption, Task, TaskId, TaskPriority};
use crate::time::{Due, Duration};

impl Manager {
    /// When to call again, if nothing happens before.
    #[must_use]
    pub fn next_due(&self) -> Due {
        let gaps = self.gaps.iter().map(|gap| gap.until);
        let by = |clock| {
            let timer = self.timers.next_due(clock);
            let others = [self.classes.next_due(clock), self.next_to_arm(clock)];
            timer.into_iter().chain(others.into_iter().flatten()).min()
        };
        Due {
            elapsed: by(Clock::Elapsed).into_iter().chain(gaps).min().map(to_instant),
            wall: by(Clock::Wall).map(to_wall),
        }
    }

    /// The task, if it is in the schedule.
    #[must_use]
    pub fn task(&self, id: TaskId) -> Option<&Task> {
        Some(&self.entry(*self.by_id.get(&id)?)?.task)
    }

    /// Whether the mission has a mode of this name.
    #[must_use]
    pub fn has_mode(&self, name: &str) -> bool {
        self.mission.modes.iter().any(|mode| mode.name == name)
    }

    /// What the tickets of an occurrence that lives are for.
    #[must_use]
    pub fn needs(&self, occurrence: Occurrence) -> Option<Needs> {
        let task = &self.entry(self.named(occurrence)?)?.task;
        let (priority, grace) = match task.preemption {
            Preemption::Wait => (TaskPriority::TOP, crate::manager::limits::GRACE),
            Preemption::Pause => (task.priority, Duration::ZERO),
            Preemption::Checkpoint { grace, .. } | Preemption::Kill { grace } => {
                (task.priority, grace)
            }
        };
        Some(Needs {
            priority,
            categories: task.categories,
            draw: task.peak_draw,
            gates: task.gates.clone(),
            grace,
        })
    }

    /// Every task of the schedule, in its order.
    pub fn tasks(&self) -> impl Iterator<Item = &Task> {
        self.in_order().map(|entry| &entry.task)
    }

    /// Where every task of the schedule stands, in its order.
    pub fn status(&self) -> impl Iterator<Item = TaskStatus> {
        self.in_order().map(|entry| self.status_at(entry))
    }

    /// Where the task stands, if it is in the schedule.
    #[must_use]
    pub fn status_of(&self, id: TaskId) -> Option<TaskStatus> {
        Some(self.status_at(self.entry(*self.by_id.get(&id)?)?))
    }

    fn in_order(&self) -> impl Iterator<Item = &Entry> {
        self.order.values().filter_map(|index| self.entry(*index))
    }

    fn status_at(&self, entry: &Entry) -> TaskStatus {
        TaskStatus { occurrence: entry.occurrence(), state: self.state(entry) }
    }

    fn state(&self, entry: &Entry) -> State {
        let attempt = entry.attempt();
        match (&entry.run.stage, entry.place) {
            (_, Place::Over) => State::Ended(entry.last.unwrap_or(Outcome::Missed)),
            (Stage::Running, _) => State::Running(attempt),
            (Stage::Stopping { .. } | Stage::Runaway(_), _) => State::Stopping(attempt),
            (Stage::Paused, _) => State::Paused(attempt, self.reason(entry)),
            (Stage::Idle, Place::Class | Place::Away) if !self.last.has_reached(entry.due) => {
                State::Pending(due(entry.due))
            }
            (Stage::Idle, _) if entry.is_resting() => State::Pending(Due::default()),
            (Stage::Idle, _) => State::Waiting(self.reason(entry)),
        }
    }

    /// What the occurrence waits for, if it waits.
    #[must_use]
    pub fn waits_for(&self, occurrence: Occurrence) -> Option<WaitsFor> {
        let entry = self.entry(self.named(occurrence)?)?;
        match self.state(entry) {
            State::Waiting(why) | State::Paused(_, why) => Some(why),
            State::Pending(_) => Some(WaitsFor::Time),
            State::Running(_) | State::Stopping(_) | State::Ended(_) => None,
        }
    }

    fn reason(&self, entry: &Entry) -> WaitsFor {
        if entry.held {
            return WaitsFor::Held;
        }
        let depends = !entry.has_started();
        let unsatisfied = entry.satisfied.iter().position(|satisfied| depends && !satisfied);
        if let Some(after) = unsatisfied.and_then(|number| entry.task.after.get(number)) {
            return WaitsFor::Dependency(after.task);
        }
        match entry.place {
            Place::Live => entry.told.clone().unwrap_or(WaitsFor::HandOver),
            _ => self.reason_in_class(entry),
        }
    }

    /// Who waits behind others of its class waits for what they wait for, or
    /// for them.
    fn reason_in_class(&self, entry: &Entry) -> WaitsFor {
        let head = self.classes.head_of(entry.class).and_then(|head| self.entry(head));
        head.and_then(|head| head.told.clone()).unwrap_or(WaitsFor::Slot)
    }

    /// How many occurrences, and blocks of the trees that they are kept in, were
    /// looked at so far: what decisions cost, on any machine.
    #[must_use]
    pub const fn looked_at(&self) -> u64 {
        self.looks.wrapping_add(self.classes.looks())
    }

    /// Whether no task lives or will become due: a schedule without routine
    /// tasks is over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        if self.shutting_down {
            return self.live.is_empty();
        }
        self.open == 0 && self.live.is_empty()
    }
}

fn due(point: Point) -> Due {
    match point.clock {
        Clock::Elapsed => Due { elapsed: Some(to_instant(point.at)), wall: None },
        Clock::Wall => Due { elapsed: None, wall: Some(to_wall(point.at)) },
    }
}
