//! The peer: SMAARTE's schedule processing as its authors describe it for the
//! optimised C version (Gillette 2019, section 4.1.2), without its sleep.
//!
//! The schedule is an array, sorted by priority each time. Then it is walked
//! from the top, with one mask of the categories in use.

/// A task as SMAARTE keeps it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) id: u32,
    pub(crate) start: u64,
    pub(crate) end: u64,
    pub(crate) conflict: u32,
    pub(crate) priority: i32,
    pub(crate) active: bool,
}

/// The whole schedule.
#[derive(Clone, Debug, Default)]
pub(crate) struct Schedule {
    pub(crate) entries: Vec<Entry>,
}

impl Schedule {
    /// One round of processing at this time; how many tasks it started.
    pub(crate) fn process(&mut self, now: u64) -> usize {
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

    /// A task has ended, or is taken out.
    pub(crate) fn remove(&mut self, id: u32) {
        self.entries.retain(|entry| entry.id != id);
    }
}
