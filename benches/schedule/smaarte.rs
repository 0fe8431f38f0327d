//! The peer: SMAARTE's schedule processing as its authors describe it for the
//! optimised C version (Gillette 2019, section 4.1.2), without its sleep.
//!
//! The schedule is an array, sorted by priority each time. Then it is walked
//! from the top, with one mask of the categories in use.

use std::collections::HashSet;
use std::hint::black_box;

use crate::stream::{self, Happening, Kind, Row};

/// A task as SMAARTE keeps it.
#[derive(Clone, Copy, Debug)]
struct Entry {
    id: u32,
    start: u64,
    end: u64,
    conflict: u32,
    priority: i32,
    active: bool,
}

/// The whole schedule.
#[derive(Debug)]
pub(crate) struct Schedule {
    entries: Vec<Entry>,
    now: u64,
}

impl Schedule {
    /// One round of processing at this time; how many tasks it started.
    fn process(&mut self) -> usize {
        let now = self.now;
        self.entries.sort_unstable_by_key(|entry| core::cmp::Reverse(entry.priority));
        self.entries.retain(|entry| entry.active || entry.end == 0 || now <= entry.end);
        let active = self.entries.iter().filter(|entry| entry.active);
        let mut used = active.fold(0, |used, entry| used | entry.conflict);
        let mut started = 0;
        for entry in &mut self.entries {
            if !entry.active && entry.start <= now && entry.conflict & used == 0 {
                entry.active = true;
                used |= entry.conflict;
                started += 1;
            }
        }
        started
    }

    fn remove(&mut self, id: u32) {
        self.entries.retain(|entry| entry.id != id);
    }
}

impl From<&Row> for Entry {
    fn from(row: &Row) -> Self {
        let Row { id, due: start, priority } = *row;
        Self { id, start, end: 0, conflict: 1, priority: priority.into(), active: false }
    }
}

impl stream::Schedule for Schedule {
    type Event = Happening;

    fn of(rows: &[Row]) -> Self {
        let mut schedule = Self { entries: rows.iter().map(Entry::from).collect(), now: 0 };
        schedule.process();
        schedule
    }

    /// Who has ended says so: it need not be looked for.
    fn make(&mut self, now: u64, happening: Happening) -> Happening {
        self.now = now;
        match happening {
            Happening::End => Happening::Remove(stream::Schedule::runs(self)),
            other => other,
        }
    }

    /// It has no tickets that could be taken or granted: then it only goes
    /// through its schedule, as after everything.
    fn happen(&mut self, event: Happening) {
        match event {
            Happening::Due | Happening::Revoke | Happening::End | Happening::Start => {}
            Happening::Add(row) => self.entries.push(Entry::from(&row)),
            Happening::Remove(id) => self.remove(id),
        }
        black_box(self.process());
    }

    fn follow(&mut self, _: Kind) {}

    fn runs(&self) -> u32 {
        let running = self.entries.iter().find(|entry| entry.active);
        running.expect("a task runs between the events").id
    }

    fn replace(&mut self, out: &[u32], rows: &[Row]) {
        let mut out: HashSet<u32> = out.iter().copied().collect();
        out.insert(stream::Schedule::runs(self));
        self.entries.retain(|entry| !out.contains(&entry.id));
        self.entries.extend(rows.iter().map(Entry::from));
        self.process();
    }
}
