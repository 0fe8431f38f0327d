//! What happens by itself, and when.

use std::collections::BTreeSet;

use crate::manager::point::{Clock, Micros, Point, Present};

/// What is due. Of what is due at one instant of one task, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// The window of the occurrence has closed.
    Closed,
    /// The next occurrence of a routine task is due.
    Next,
    /// The latest end has come.
    Cutoff,
    /// The attempt runs longer than its duration.
    Overrun,
    /// The attempt has been silent for too long.
    Silent,
}

/// How many kinds there are.
pub(crate) const KINDS: usize = 5;

/// All of them.
pub(crate) const EVERY: [Kind; KINDS] =
    [Kind::Closed, Kind::Next, Kind::Cutoff, Kind::Overrun, Kind::Silent];

/// The timers of one task, for their removal.
pub(crate) type Set = [Option<Point>; KINDS];

#[derive(Clone, Debug, Default)]
pub(crate) struct Timers {
    elapsed: BTreeSet<(Micros, u32, Kind)>,
    wall: BTreeSet<(Micros, u32, Kind)>,
}

impl Timers {
    /// Sets a timer of a task, or takes it away.
    pub(crate) fn set(&mut self, set: &mut Set, task: u32, kind: Kind, at: Option<Point>) {
        let Some(place) = set.get_mut(kind as usize) else { return };
        if *place == at {
            return;
        }
        if let Some(point) = core::mem::replace(place, at) {
            self.side(point.clock).remove(&(point.at, task, kind));
        }
        if let Some(point) = at {
            self.side(point.clock).insert((point.at, task, kind));
        }
    }

    /// The next one that is due by now.
    pub(crate) fn ripe(&self, now: Present) -> Option<(u32, Kind)> {
        let by = |side: &BTreeSet<(Micros, u32, Kind)>, now: Micros| {
            side.first().copied().filter(|(at, ..)| *at <= now)
        };
        let elapsed = by(&self.elapsed, now.elapsed);
        let wall = by(&self.wall, now.wall);
        // How long ago makes the two clocks comparable.
        let ago = |now: Micros, timer: Option<(Micros, u32, Kind)>| {
            timer.map(|(at, task, kind)| (at.saturating_sub(now), task, kind))
        };
        let first = ago(now.elapsed, elapsed).into_iter().chain(ago(now.wall, wall)).min();
        first.map(|(_, task, kind)| (task, kind))
    }

    pub(crate) fn next_due(&self, clock: Clock) -> Option<Micros> {
        let side = match clock {
            Clock::Elapsed => &self.elapsed,
            Clock::Wall => &self.wall,
        };
        side.first().map(|(at, ..)| *at)
    }

    fn side(&mut self, clock: Clock) -> &mut BTreeSet<(Micros, u32, Kind)> {
        match clock {
            Clock::Elapsed => &mut self.elapsed,
            Clock::Wall => &mut self.wall,
        }
    }
}
