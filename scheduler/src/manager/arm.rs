//! Starts that are prepared for: what is due next is in the journal, durable,
//! before it is due, so that its start need not wait for a disk.

use crate::manager::entry::Place;
use crate::manager::limits::{ARMED_AHEAD, ARMED_WITHIN, MOST_ARMED};
use crate::manager::point::{Clock, Micros, from_duration};
use crate::manager::step::Step;
use crate::manager::{Action, Manager, Record};

impl Step<'_> {
    /// Arms who is due next, by each clock.
    pub(crate) fn arm(&mut self) {
        let mut wrote = false;
        for (side, clock) in [Clock::Elapsed, Clock::Wall].into_iter().enumerate() {
            let Some(at) = self.manager.classes.next_due(clock) else { continue };
            let ahead = at.saturating_sub(self.now.by(clock));
            let range = from_duration(ARMED_AHEAD)..=from_duration(ARMED_WITHIN);
            if !range.contains(&ahead) || self.manager.shutting_down {
                continue;
            }
            let armed_for = self.manager.armed_for.get_mut(side);
            if armed_for.is_none_or(|before| before.replace(at) == Some(at)) {
                continue;
            }
            let most = MOST_ARMED.saturating_sub(self.manager.armed.len());
            for index in self.manager.classes.next_group(clock, most) {
                wrote |= self.arm_one(index);
            }
        }
        if wrote {
            self.act(Action::Sync);
        }
    }

    fn arm_one(&mut self, index: u32) -> bool {
        let Some(entry) = self.entry_mut(index) else { return false };
        if core::mem::replace(&mut entry.armed, true) {
            return false;
        }
        let occurrence = entry.occurrence();
        self.manager.armed.push(index);
        self.write(Record::Armed { occurrence });
        true
    }

    /// Who was due and is not about to start, or was put off: it will start by
    /// another cause or later, and be synced or armed again then.
    pub(crate) fn disarm_the_late(&mut self) {
        for index in self.manager.armed.clone() {
            let Some(entry) = self.entry(index) else { continue };
            let waits = match entry.place {
                Place::Class => {
                    let ahead = self.now.until(entry.due);
                    !(1..=from_duration(ARMED_WITHIN)).contains(&ahead)
                }
                Place::Live => entry.run.asked != crate::manager::entry::Asked::Waiting,
                Place::Away | Place::Over => true,
            };
            if waits && self.disarm(index) {
                let Some(entry) = self.entry(index) else { continue };
                let occurrence = entry.occurrence();
                self.write(Record::Disarmed { occurrence });
            }
        }
    }

    /// Answers whether it was armed.
    pub(crate) fn disarm(&mut self, index: u32) -> bool {
        let Some(entry) = self.entry_mut(index) else { return false };
        if !core::mem::replace(&mut entry.armed, false) {
            return false;
        }
        self.manager.armed.retain(|other| *other != index);
        true
    }
}

impl Manager {
    /// When whoever is due next by this clock is to be armed, if that is ahead.
    pub(crate) fn next_to_arm(&self, clock: Clock) -> Option<Micros> {
        let due = self.classes.next_due(clock)?;
        let at = due.saturating_sub(from_duration(ARMED_WITHIN));
        (at > self.last.by(clock) && !self.shutting_down).then_some(at)
    }
}
