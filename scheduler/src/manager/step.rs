//! One step: what happened at one instant, and one decision.

use crate::manager::entry::Entry;
use crate::manager::point::{Micros, Point, Present, to_wall};
use crate::manager::timers::Kind;
use crate::manager::{Action, Event, Manager, Note, Record};
use crate::time::Now;

/// A manager at an instant, and where its actions go.
pub(crate) struct Step<'a> {
    pub(crate) manager: &'a mut Manager,
    pub(crate) now: Present,
    out: &'a mut Vec<Action>,
}

impl<'a> Step<'a> {
    pub(crate) fn new(manager: &'a mut Manager, now: Now, out: &'a mut Vec<Action>) -> Self {
        Self { manager, now: now.into(), out }
    }

    /// Ends come first: what ends at an instant is not there any more for what
    /// is due at it. Nothing is decided before everything is known.
    pub(crate) fn apply(&mut self, events: Vec<Event>) {
        let (exits, others): (Vec<_>, Vec<_>) =
            events.into_iter().partition(|event| matches!(event, Event::Exited { .. }));
        self.manager.classes.advance(self.now);
        for event in exits {
            self.event(event);
        }
        self.look_at_the_clock();
        self.ring_timers();
        self.end_gaps();
        for event in others {
            self.event(event);
        }
        self.decide();
        self.manager.last = self.now;
    }

    fn event(&mut self, event: Event) {
        match event {
            Event::Exited { attempt, exit } => self.exited(attempt, exit),
            Event::Stopped { attempt } => self.stopped(attempt),
            Event::Runaway { attempt } => self.ran_away(attempt),
            Event::Heartbeat { attempt } => self.alive(attempt),
            Event::Granted { occurrence } => self.granted(occurrence),
            Event::Taken { occurrence, by } => self.taken(occurrence, by),
            Event::Blocked { occurrence, why } => self.blocked(occurrence, why),
            Event::Refused { occurrence, why } => self.refused(occurrence, why),
            Event::Reading(reading) => self.reading(reading),
            Event::Telecommand { id, telecommand } => self.telecommand(id, telecommand),
        }
    }

    /// Lets everything happen that is due by now.
    pub(crate) fn ring_timers(&mut self) {
        while let Some((index, kind)) = self.manager.timers.ripe(self.now) {
            self.manager.looks = self.manager.looks.wrapping_add(1);
            self.timer(index, kind);
        }
    }

    fn timer(&mut self, index: u32, kind: Kind) {
        self.set_timer(index, kind, None);
        match kind {
            Kind::Closed => self.closed(index),
            Kind::Next => self.next_is_due(index),
            Kind::Cutoff => self.cut_off(index),
            Kind::Overrun => self.overran(index),
            Kind::Silent => self.silent(index),
        }
    }

    fn end_gaps(&mut self) {
        let now = self.now.elapsed;
        self.manager.gaps.retain(|gap| gap.until > now);
    }

    pub(crate) fn set_timer(&mut self, index: u32, kind: Kind, at: Option<Point>) {
        let manager = &mut *self.manager;
        if let Some(entry) = manager.entries.get_mut(index) {
            manager.timers.set(&mut entry.timers, index, kind, at);
        }
    }

    /// A timer so long from now, by the clock that never jumps.
    pub(crate) fn set_timer_in(&mut self, index: u32, kind: Kind, micros: Micros) {
        let at = Point::elapsed(self.now.elapsed.saturating_add(micros));
        self.set_timer(index, kind, Some(at));
    }

    pub(crate) fn entry(&self, index: u32) -> Option<&Entry> {
        self.manager.entry(index)
    }

    pub(crate) fn entry_mut(&mut self, index: u32) -> Option<&mut Entry> {
        self.manager.entry_mut(index)
    }

    pub(crate) fn act(&mut self, action: Action) {
        self.out.push(action);
    }

    pub(crate) fn note(&mut self, note: Note) {
        self.act(Action::Note(note));
    }

    pub(crate) fn write(&mut self, record: Record) {
        self.act(Action::Journal(record));
    }

    pub(crate) fn wall(&self) -> crate::time::UnixTime {
        to_wall(self.now.wall)
    }
}
