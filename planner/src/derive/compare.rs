//! Once all that a candidate changes is behind, somebody may know what follows.

use crate::energy::Watch;

use super::super::mark::{After, Mark, Open, Up};
use super::super::var::Var;
use super::Sweep;

/// Where to go on, if not here; nowhere: all that follows is known.
type Leap = Option<Option<Mark>>;

impl<W: Watch> Sweep<'_, '_, W> {
    /// At a sleep's begin.
    pub(super) fn compare(&mut self) -> Leap {
        let own = self.energy.frame.own;
        if self.met.1 < own.needs.len() || !self.cursor.is_past(&own.steps) {
            return None;
        }
        let mark = Mark { cursor: self.cursor, met: self.met.0, phases: self.phases };
        let after = self.watch.asleep(&mark, &mut self.reach);
        self.leaps(after)
    }

    /// In a phase that lasts until then at least.
    pub(super) fn compare_open(&mut self, begun: Up, until: Var) -> Leap {
        let own = self.energy.frame.own;
        if self.met.1 < own.needs.len() || !until.is_fixed() || !self.watch.compares() {
            return None;
        }
        let computer = self.problem.computer;
        if own.steps.last().is_some_and(|last| !self.reach.le(last.at, until)) {
            return None;
        }
        // Once it was awake for long enough, it no longer matters since when.
        let long = self.reach.le(begun.counted.later(computer.min_awake), until);
        let (met, phases) = (self.met.0, self.phases);
        let open = Open { begun, until, cursor: self.cursor, met, phases };
        if !self.watch.knows(&open, long, &mut self.reach) {
            return None;
        }
        self.go(until, computer.awake);
        let open = Open { cursor: self.cursor, ..open };
        let after = self.watch.awake(&open, &mut self.reach);
        self.leaps(after)
    }

    const fn leaps(&mut self, after: After) -> Leap {
        match after {
            After::On => None,
            After::From(mark) => Some(Some(mark)),
            After::Over => {
                self.is_over = true;
                Some(None)
            }
        }
    }
}
