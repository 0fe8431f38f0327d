//! What records add up to.
//!
//! A pure function: it opens no file, and records that make no sense together
//! are no panic. Records of a task that is not there say nothing.

use std::collections::BTreeMap;

use crate::journal::entry::{Base, Entry, Kept};
use crate::journal::storage::Boot;
use crate::manager::{Attempt, Occurrence, Record, Restored};
use crate::task::{Outcome, Task, TaskId};
use crate::time::UnixTime;

/// What these records add up to, if no power was lost between them.
pub fn replay(records: impl IntoIterator<Item = Record>) -> Restored {
    let mut replay = Replay::default();
    for record in records {
        replay.apply(record);
    }
    replay.into_restored()
}

/// The same for records that stand encoded in these bytes, one after the other,
/// up to the first that is none. Any bytes will do: it is how a test tries them.
#[must_use]
pub fn replay_bytes(mut bytes: &[u8]) -> Restored {
    let mut replay = Replay::default();
    while let Ok((record, rest)) = postcard::take_from_bytes(bytes) {
        replay.apply(record);
        bytes = rest;
    }
    replay.into_restored()
}

/// Adds records up, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Replay {
    base: Base,
    /// Those that somebody may ask for. One that was removed is among them
    /// while an attempt of it may have to be cleared away, or a task in the
    /// schedule asks what became of it. It goes with the record that ends this,
    /// so that a compaction, whenever it comes, changes nothing.
    tasks: BTreeMap<TaskId, Kept>,
    /// Which tasks in the schedule name each one, and how often.
    named: BTreeMap<TaskId, BTreeMap<TaskId, usize>>,
}

impl Replay {
    /// The journal was opened, in this start of the host. Unless it is the one
    /// of the time before, or the journal was closed in between, what was not
    /// synced may be lost: who was armed may have started.
    pub fn opened(&mut self, boot: Boot) {
        if !self.base.closed && !self.base.boot.is_certainly(boot) {
            for kept in self.tasks.values_mut() {
                kept.armed_in_vain |= kept.armed.is_some();
            }
        }
        self.base.boot = boot;
        self.base.closed = false;
    }

    /// The journal was closed in order.
    pub fn closed(&mut self) {
        self.base.closed = true;
    }

    /// Whether it was closed, or nothing was ever written to it.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.base.closed
    }

    /// Adds a record.
    pub fn apply(&mut self, record: Record) {
        match record {
            Record::Accepted { task, load, position, wall, .. } => {
                self.accept(*task, load, position, wall);
            }
            Record::Changed { task, held } => self.change(*task, held),
            Record::Removed { task, load } => self.remove(task, load),
            Record::Armed { occurrence } => self.arm(occurrence, true),
            Record::Disarmed { occurrence } => self.arm(occurrence, false),
            Record::Starting { attempt } => self.start(attempt),
            Record::Paused { .. } => {}
            Record::Over { attempt, .. } => self.over(attempt),
            Record::Ended { occurrence, outcome, wall } => self.end(occurrence, outcome, wall),
            Record::Mode { name, entered } => self.mode(name, entered),
            Record::Leaving { task, load } => {
                self.mark(task, load, |kept| kept.leaving = true);
            }
            Record::CleansUp { task, load } => {
                self.mark(task, load, |kept| kept.cleans_up = true);
            }
        }
    }

    /// What a manager goes on with.
    #[must_use]
    pub fn restored(&self) -> Restored {
        self.clone().into_restored()
    }

    /// The same, without copying all tasks.
    #[must_use]
    pub fn into_restored(self) -> Restored {
        let mut tasks: Vec<_> = self.tasks.into_values().map(Kept::restored).collect();
        tasks.sort_by_key(|task| task.position);
        let Base { modes, next_position, .. } = self.base;
        Restored { tasks, modes, next_position }
    }

    /// The entries of a snapshot: applied to nothing they make this again.
    pub(super) fn entries(&self) -> impl Iterator<Item = Entry> {
        core::iter::once(Entry::Base(self.base.clone()))
            .chain(self.tasks.values().map(|kept| Entry::Kept(Box::new(kept.clone()))))
            .chain(core::iter::once(Entry::Complete(self.known())))
    }

    pub(super) fn apply_entry(&mut self, entry: Entry) {
        match entry {
            Entry::Opened(boot) => self.opened(boot),
            Entry::Closed => self.closed(),
            Entry::Record(record) => self.apply(record),
            Entry::Base(base) => self.base = base,
            Entry::Kept(kept) => self.insert(*kept),
            Entry::Continues(_) | Entry::Complete(_) => {}
        }
    }

    /// In which start of the host the journal was opened last.
    pub(super) const fn last_boot(&self) -> Boot {
        self.base.boot
    }

    /// How many tasks it knows.
    pub(super) fn known(&self) -> u64 {
        u64::try_from(self.tasks.len()).unwrap_or(u64::MAX)
    }

    fn accept(&mut self, task: Task, load: u32, position: u64, accepted: UnixTime) {
        self.base.next_position = self.base.next_position.max(position.saturating_add(1));
        let kept = Kept {
            load,
            position,
            accepted,
            held: false,
            removed: false,
            ended: None,
            attempts: (0, 0),
            running: None,
            armed: None,
            armed_in_vain: false,
            has_to_clean: false,
            satisfied: vec![false; task.after.len()],
            leaving: false,
            cleans_up: false,
            ran_until: None,
            task,
        };
        self.insert(kept);
    }

    fn insert(&mut self, kept: Kept) {
        if !kept.removed {
            self.name(&kept.task);
        }
        if let Some(before) = self.tasks.insert(kept.task.id, kept)
            && !before.removed
        {
            self.unname(&before.task);
        }
    }

    fn remove(&mut self, id: TaskId, load: u32) {
        if let Some(kept) =
            self.tasks.get_mut(&id).filter(|kept| kept.load == load && !kept.removed)
        {
            kept.removed = true;
            let task = kept.task.clone();
            self.unname(&task);
            self.forget(id);
        }
    }

    /// Forgets a task that nobody asks for any more.
    fn forget(&mut self, id: TaskId) {
        let asks = |kept: &Kept| !kept.removed || kept.running.is_some();
        if !self.named.contains_key(&id) && !self.tasks.get(&id).is_none_or(asks) {
            self.tasks.remove(&id);
        }
    }

    fn name(&mut self, task: &Task) {
        for named in names(task) {
            *self.named.entry(named).or_default().entry(task.id).or_default() += 1;
        }
    }

    fn unname(&mut self, task: &Task) {
        for named in names(task) {
            let Some(askers) = self.named.get_mut(&named) else { continue };
            if let Some(times) = askers.get_mut(&task.id) {
                *times -= 1;
                if *times == 0 {
                    askers.remove(&task.id);
                }
            }
            if askers.is_empty() {
                self.named.remove(&named);
                self.forget(named);
            }
        }
    }

    fn change(&mut self, task: Task, held: bool) {
        let Some(kept) = self.tasks.get_mut(&task.id) else { return };
        kept.held = held;
        if kept.removed {
            return;
        }
        let before = core::mem::replace(&mut kept.task, task.clone());
        self.name(&task);
        self.unname(&before);
    }

    fn of(&mut self, occurrence: Occurrence) -> Option<&mut Kept> {
        self.tasks.get_mut(&occurrence.task).filter(|kept| kept.load == occurrence.load)
    }

    fn mark(&mut self, id: TaskId, load: u32, mark: impl FnOnce(&mut Kept)) {
        if let Some(kept) = self.tasks.get_mut(&id).filter(|kept| kept.load == load) {
            mark(kept);
        }
    }

    fn arm(&mut self, occurrence: Occurrence, armed: bool) {
        if let Some(kept) = self.of(occurrence) {
            kept.armed = armed.then_some(occurrence);
            kept.armed_in_vain = false;
        }
    }

    fn start(&mut self, attempt: Attempt) {
        if let Some(kept) = self.of(attempt.occurrence) {
            kept.running = Some(attempt);
            kept.has_to_clean = false;
            kept.use_dependencies(attempt);
            kept.began(attempt);
            kept.armed = None;
            kept.armed_in_vain = false;
        }
    }

    /// Also the answer of a manager to an attempt of which nobody knows whether
    /// it started.
    fn over(&mut self, attempt: Attempt) {
        if let Some(kept) = self.of(attempt.occurrence) {
            kept.running = kept.running.filter(|running| *running != attempt);
            if kept.began(attempt) {
                kept.use_dependencies(attempt);
            }
            kept.armed = None;
            kept.armed_in_vain = false;
            self.forget(attempt.occurrence.task);
        }
    }

    fn end(&mut self, occurrence: Occurrence, outcome: Outcome, wall: UnixTime) {
        let Some(kept) = self.of(occurrence) else { return };
        if outcome != Outcome::Missed {
            kept.ran_until = Some(wall);
        }
        kept.end(occurrence.number, outcome);
        let cleanup = kept.task.cleanup.filter(|_| is_cleaned_up_after(outcome));
        if let Some(cleanup) = cleanup.and_then(|id| self.tasks.get_mut(&id)) {
            cleanup.has_to_clean = true;
        }
        self.satisfy(occurrence.task, outcome);
        self.forget(occurrence.task);
    }

    /// Who asks for this outcome of the task has it, until it is used.
    fn satisfy(&mut self, id: TaskId, outcome: Outcome) {
        let Some(askers) = self.named.get(&id) else { return };
        for asker in askers.keys() {
            let Some(kept) = self.tasks.get_mut(asker) else { continue };
            for (prior, satisfied) in kept.task.after.iter().zip(&mut kept.satisfied) {
                *satisfied |= prior.task == id && prior.status.includes(outcome);
            }
        }
    }

    fn mode(&mut self, name: String, entered: bool) {
        self.base.modes.retain(|mode| *mode != name);
        if entered {
            self.base.modes.push(name);
        }
    }
}

const fn is_cleaned_up_after(outcome: Outcome) -> bool {
    matches!(outcome, Outcome::Failed | Outcome::Aborted)
}

/// The tasks of which this one asks what became of them.
fn names(task: &Task) -> impl Iterator<Item = TaskId> {
    task.after.iter().map(|prior| prior.task)
}
