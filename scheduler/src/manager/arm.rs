//! Starts that are prepared for: what is due next is in the journal, durable,
//! before it is due, so that its start need not wait for a disk.

use crate::manager::entry::Place;
use crate::manager::limits::{ARMED_AHEAD, MOST_ARMED};
use crate::manager::point::{Clock, from_duration};
use crate::manager::step::Step;
use crate::manager::{Action, Record};

impl Step<'_> {
    /// Arms who is due next, by each clock.
    pub(crate) fn arm(&mut self) {
        let mut wrote = false;
        for (side, clock) in [Clock::Elapsed, Clock::Wall].into_iter().enumerate() {
            let Some(at) = self.manager.classes.next_due(clock) else { continue };
            let ahead = at.saturating_sub(self.now.by(clock));
            if ahead < from_duration(ARMED_AHEAD) || self.manager.shutting_down {
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

    /// Who was due and is not about to start: it will start by another cause,
    /// and be synced then.
    pub(crate) fn disarm_the_late(&mut self) {
        for index in self.manager.armed.clone() {
            let Some(entry) = self.entry(index) else { continue };
            let waits = match entry.place {
                Place::Class => self.now.has_reached(entry.due),
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
