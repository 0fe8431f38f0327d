//! How a sleep ends: for what needs the computer next, or before the charge
//! passes the maximum.

use crate::derive::own::Late;
use crate::derive::var::Var;
use crate::energy::{Cursor, Watch};
use crate::problem::Draw;

use super::{Sleep, Sweep, Up, Wake};

impl<W: Watch> Sweep<'_, '_, W> {
    /// How a sleep ends that begins at the cursor, or is in progress there, and
    /// counts from `since` on.
    pub(super) fn wake(&mut self, cursor: Cursor, since: Var, sleep: Sleep) -> Wake {
        let first = matches!(sleep, Sleep::InProgress);
        let computer = self.problem.computer;
        let end = self.end();
        let need = self.need();
        let mut until = end;
        if let Some(need) = need {
            until = self.wakeup_for(need);
            if first && self.reach.lt(until, cursor.at) {
                let by = cursor.at.at - until.at;
                self.is_late(Late { at: need.from, who: need.who, by });
                let up = cursor.at.later(computer.wakeup_time);
                let up = self.min(up, self.barrier(cursor.at));
                return Wake::Up(Up { wakeup: cursor.at, up, counted: up });
            }
        }
        let Some(full) = self.full(cursor, until, sleep) else {
            let Some(need) = need else { return Wake::Never };
            if first && self.reach.lt(until.minus(since), Var::fixed(computer.min_sleep)) {
                let by = computer.min_sleep - (until.at - since.at);
                self.is_late(Late { at: need.from, who: need.who, by });
            }
            let up = until.later(computer.wakeup_time);
            return Wake::Up(Up { wakeup: until, up, counted: up });
        };
        self.watch.depends(cursor.at.at);
        let mut wakeup = full;
        if need.is_none() {
            let last = end.later(-computer.min_awake - computer.wakeup_time);
            if self.reach.lt(last, wakeup) {
                if !first && self.reach.lt(last.minus(since), Var::fixed(computer.min_sleep)) {
                    return Wake::Stay;
                }
                wakeup = self.max(last, cursor.at);
            }
        }
        let up = self.min(wakeup.later(computer.wakeup_time), self.barrier(cursor.at));
        Wake::Up(Up { wakeup, up, counted: up })
    }

    /// The last instant of a sleep at which the charge is not above the
    /// maximum, where it comes above it until then.
    ///
    /// Where a shutdown was put off for it, the charge at the shortest sleep's
    /// end is less than a millisecond's worth below the maximum: a comparison
    /// there would say nothing of a shift by a millisecond.
    fn full(&mut self, mut cursor: Cursor, until: Var, sleep: Sleep) -> Option<Var> {
        let battery = self.problem.battery;
        if battery.max >= battery.capacity {
            return None;
        }
        let max = Var::fixed(battery.max);
        let fits = if let Sleep::Begins(fits) = sleep { fits } else { None };
        if fits.is_none() && self.reach.lt(max, cursor.charge) {
            return Some(cursor.at);
        }
        loop {
            let step = self.energy.next(&cursor, &mut self.reach);
            let step = step.map(|step| step.at).filter(|&at| self.reach.lt(at, until));
            let to = step.unwrap_or(until);
            let net = self.energy.net(&cursor, Draw::default());
            let charge = cursor.charge.plus(to.minus(cursor.at).times(net));
            let is_known = fits.is_some_and(|fits| self.reach.le(to, fits));
            if net > 0 && !is_known && self.reach.lt(max, charge) {
                return Some(cursor.at.plus(max.minus(cursor.charge).divided(net)));
            }
            step?;
            cursor = self.think(cursor, to, Draw::default());
        }
    }
}
