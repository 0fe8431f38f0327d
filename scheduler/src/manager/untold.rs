//! What happened and is told later: runs of misses that go on.

use crate::manager::{Manager, Note};

impl Manager {
    /// Misses that are not told of yet: a run of them is told of once, when it
    /// is over.
    pub fn untold(&self) -> impl Iterator<Item = Note> {
        let entries = self.order.values().filter_map(|index| self.entry(*index));
        entries.filter_map(|entry| {
            let misses = entry.misses.as_ref()?;
            Some(Note::Missed {
                task: entry.task.id,
                first: misses.first,
                last: misses.last,
                count: misses.count,
                why: misses.why.to_owned(),
            })
        })
    }
}
