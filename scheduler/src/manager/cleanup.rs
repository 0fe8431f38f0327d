//! Tasks that clean up: each waits for the failure of others, and leaves the
//! schedule when nobody is left who could fail.

use crate::manager::Record;
use crate::manager::entry::{Entry, Run};
use crate::manager::point::Point;
use crate::manager::step::Step;

impl Step<'_> {
    /// Makes a task one that waits for the failure of another one.
    pub(crate) fn make_clean_up(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index).filter(|entry| !entry.cleans_up) else { return };
        entry.cleans_up = true;
        let (task, load) = (entry.task.id, entry.load);
        self.manager.open = self.manager.open.saturating_sub(1);
        self.write(Record::CleansUp { task, load });
    }

    /// A task is over, or gone: it fails no more. Who cleaned up after it alone
    /// has nothing to wait for.
    pub(crate) fn needs_no_cleanup(&mut self, index: u32) {
        let Some(cleanup) = self.entry(index).and_then(|entry| entry.task.cleanup) else { return };
        let Some(needed) = self.manager.needed.get_mut(&cleanup) else { return };
        *needed = needed.saturating_sub(1);
        if *needed > 0 {
            return;
        }
        self.manager.needed.remove(&cleanup);
        if let Some(index) = self.manager.by_id.get(&cleanup).copied() {
            self.may_retire(index);
        }
    }

    /// Before the next decision a task that cleans up leaves, if nobody needs it.
    pub(crate) fn may_retire(&mut self, index: u32) {
        let entry = self.entry(index);
        if let Some(position) = entry.filter(|entry| entry.cleans_up).map(|entry| entry.position) {
            self.manager.idle.push_back((index, position));
        }
    }

    /// What it did last is told as of any task that is over. One that never had
    /// to do anything is gone.
    pub(crate) fn retire(&mut self, index: u32, position: u64) {
        let here = |entry: &&mut Entry| entry.position == position && entry.is_resting();
        let Some(entry) = self.manager.entries.get_mut(index).filter(here) else { return };
        if self.manager.needed.contains_key(&entry.task.id) {
            return;
        }
        let Some(outcome) = entry.last else { return self.take_out(index) };
        entry.current = entry.current.saturating_sub(1);
        self.over(index);
        self.settle_dependants(index, outcome, true);
    }

    /// An occurrence has failed or was aborted: the task that cleans up after
    /// it is due. If it is at work it has to do so once more.
    pub(crate) fn clean_up(&mut self, index: u32) {
        let cleanup = self.entry(index).and_then(|entry| entry.task.cleanup);
        let Some(index) = cleanup.and_then(|id| self.manager.by_id.get(&id).copied()) else {
            return;
        };
        let Some(entry) = self.entry_mut(index).filter(|entry| entry.cleans_up) else { return };
        if entry.is_resting() {
            self.begin_cleaning(index);
        } else {
            entry.next = entry.current.saturating_add(2);
        }
    }

    /// A task that cleans up has done so, and waits for the next time; that may
    /// have come meanwhile.
    pub(crate) fn rest(&mut self, index: u32) {
        let Some(entry) = self.entry_mut(index) else { return };
        let once_more = entry.next > entry.current.saturating_add(1);
        entry.current = entry.current.saturating_add(1);
        entry.next = entry.current;
        if once_more {
            self.begin_cleaning(index);
        } else {
            self.may_retire(index);
        }
    }

    pub(crate) fn begin_cleaning(&mut self, index: u32) {
        let now = self.now;
        let Some(entry) = self.entry_mut(index) else { return };
        entry.next = entry.current.saturating_add(1);
        entry.attempts = 0;
        entry.failures = 0;
        entry.saved = false;
        entry.arrival = now.elapsed;
        entry.due = Point::elapsed(now.elapsed);
        entry.run = Run::new();
        entry.told = None;
        if entry.is_ready() {
            self.enter(index);
        }
    }
}

impl Entry {
    /// A task that cleans up and has nothing to clean up: its next occurrence
    /// has not begun.
    pub(crate) const fn is_resting(&self) -> bool {
        self.cleans_up && self.next == self.current
    }
}
