//! What is heard of the agents.

use crate::manager::entry::{Asked, Place, Stage, Then};
use crate::manager::step::Step;
use crate::manager::{Note, Occurrence, WaitsFor};

impl Step<'_> {
    fn live(&self, occurrence: Occurrence) -> Option<u32> {
        let index = self.manager.named(occurrence)?;
        (self.entry(index)?.place == Place::Live).then_some(index)
    }

    /// Its tickets are valid. The decision lets it start, or hands them back.
    pub(crate) fn granted(&mut self, occurrence: Occurrence) {
        let Some(index) = self.live(occurrence) else { return };
        let Some(entry) = self.entry_mut(index) else { return };
        if entry.run.asked != Asked::No {
            entry.run.asked = Asked::Granted;
        }
    }

    /// Its tickets were taken: its commands have no effect any more, and its
    /// body is stopped.
    pub(crate) fn taken(&mut self, occurrence: Occurrence, by: String) {
        let Some(index) = self.live(occurrence) else { return };
        let Some(entry) = self.entry_mut(index) else { return };
        if entry.run.asked != Asked::No {
            entry.run.asked = Asked::Waiting;
        }
        self.pre_empt(index, by);
    }

    /// Its tickets wait for something outside: whoever needs the same need not
    /// wait for it meanwhile.
    pub(crate) fn blocked(&mut self, occurrence: Occurrence, why: String) {
        let Some(index) = self.live(occurrence) else { return };
        let Some(entry) = self.entry_mut(index) else { return };
        if matches!(entry.run.asked, Asked::Waiting | Asked::Blocked(_)) {
            entry.run.asked = Asked::Blocked(why.clone());
            self.tell_waits(index, WaitsFor::Tickets(why));
        }
    }

    /// Its tickets can never be had.
    pub(crate) fn refused(&mut self, occurrence: Occurrence, why: String) {
        let Some(index) = self.live(occurrence) else { return };
        let Some(entry) = self.entry_mut(index) else { return };
        entry.run.asked = Asked::No;
        match entry.run.stage {
            Stage::Idle => self.never_runs(index, why),
            _ => {
                let task = entry.task.id;
                self.note(Note::NeverRuns { task, why: why.clone() });
                self.abort(index, &why);
            }
        }
    }

    /// Takes the tickets of a body that must not run, without anybody else
    /// wanting them.
    pub(crate) fn withdraw(&mut self, index: u32, why: String) {
        self.give_back(index);
        self.pre_empt(index, why);
    }

    /// Whether the body will go on, or be made again.
    pub(crate) fn comes_back(&self, index: u32) -> bool {
        self.entry(index).is_some_and(|entry| {
            matches!(entry.run.stage, Stage::Paused | Stage::Stopping { then: Then::Again, .. })
        })
    }

    /// Tells what an occurrence waits for, once for each change of the reason.
    pub(crate) fn tell_waits(&mut self, index: u32, waits_for: WaitsFor) {
        let Some(entry) = self.entry_mut(index) else { return };
        if entry.told.as_ref().is_some_and(|told| told.is_like(&waits_for)) {
            return;
        }
        entry.told = Some(waits_for.clone());
        let occurrence = entry.occurrence();
        self.note(Note::Waits { occurrence, waits_for });
    }
}

impl WaitsFor {
    /// Whether only an amount differs: a shortage that grows or shrinks is no
    /// new reason.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Draw { .. }, Self::Draw { .. })
            | (Self::Memory { .. }, Self::Memory { .. })
            | (Self::Storage { .. }, Self::Storage { .. }) => true,
            (Self::Battery { wanted, .. }, Self::Battery { wanted: other, .. }) => wanted == other,
            (a, b) => a == b,
        }
    }
}
