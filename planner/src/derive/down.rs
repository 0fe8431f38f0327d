//! When an awake phase may end: only where a sleep of the minimum length does
//! not pass the maximum state of charge.

use crate::derive::own::VarNeed;
use crate::derive::var::Var;
use crate::energy::{Cursor, Watch};

use super::{Down, Sleep, Sweep, Wake};

/// A shutdown that might begin at the first cursor, and is over at the second:
/// how far a shortest sleep, which ends at `until`, would go past the maximum
/// then.
#[derive(Clone, Copy)]
struct Try {
    down: Cursor,
    asleep: Cursor,
    until: Var,
    over: Var,
    /// The later it is, the shorter the sleep: the plan's end cuts it.
    shrinks: bool,
}

impl<W: Watch> Sweep<'_, '_, W> {
    /// From `earliest` on, and before the phase is one with the next need's.
    pub(super) fn down(&mut self, earliest: Var, need: Option<VarNeed>) -> Down {
        let computer = self.problem.computer;
        let last = match need {
            Some(need) => self.wakeup_for(need).later(-computer.min_sleep),
            None => self.end(),
        };
        let last = last.later(-computer.shutdown_time);
        let cursor = self.think(self.cursor, earliest, computer.awake);
        let mut now = self.attempt(cursor);
        if self.reach.le(now.over, Var::fixed(0)) {
            return self.accept(now);
        }
        self.watch.depends(earliest.at);
        loop {
            let next = self.next_change(now, last);
            if self.reach.le(next, now.down.at) {
                return if need.is_some() { Down::Later } else { Down::Never };
            }
            let cursor = self.think(now.down, next, computer.awake);
            let then = self.attempt(cursor);
            if self.reach.le(then.over, Var::fixed(0)) {
                let first = self.between(now, then);
                let cursor = self.think(now.down, first, computer.awake);
                let found = self.attempt(cursor);
                return self.accept(found);
            }
            now = then;
        }
    }

    fn accept(&mut self, found: Try) -> Down {
        match self.wake(found.asleep, found.asleep.at, Sleep::Begins(Some(found.until))) {
            Wake::Stay => Down::Never,
            Wake::Never => Down::At(found.down.at, None),
            Wake::Up(up) => Down::At(found.down.at, Some(up)),
        }
    }

    fn attempt(&mut self, down: Cursor) -> Try {
        let computer = self.problem.computer;
        let until = down.at.later(computer.shutdown_time);
        let asleep = self.think(down, until, computer.shutdown);
        let battery = self.problem.battery;
        // A sleep that the plan's end cuts needs only what is left of it.
        let left = self.end().minus(until);
        // A sleep of nothing would end at once, again and again.
        let shortest = Var::fixed(computer.min_sleep.max(1));
        let shrinks = self.reach.le(left, shortest);
        let sleep = if shrinks { left } else { shortest };
        let until = if shrinks { self.end() } else { until.plus(shortest) };
        let gain = sleep.times(battery.idle.max(0));
        let mut over = asleep.charge.plus(gain).later(-battery.max);
        // A full battery is not above a maximum that is all it can hold.
        if battery.max >= battery.capacity {
            over = Var::fixed(0);
        }
        Try { down, asleep, until, over, shrinks }
    }

    /// The next instant at which `over` may go on in another direction.
    fn next_change(&mut self, now: Try, last: Var) -> Var {
        let computer = self.problem.computer;
        let mut next = last;
        if let Some(step) = self.energy.next(&now.down, &mut self.reach) {
            next = self.min(next, step.at);
        }
        if let Some(step) = self.energy.next(&now.asleep, &mut self.reach) {
            next = self.min(next, step.at.later(-computer.shutdown_time));
        }
        let cut = self.end().later(-computer.shutdown_time - computer.min_sleep.max(1));
        if self.reach.lt(now.down.at, cut) {
            next = self.min(next, cut);
        }
        next
    }

    /// The first instant at which it is not over the maximum: a straight line,
    /// or, where the capacity cuts something off, a concave one.
    fn between(&mut self, now: Try, then: Try) -> Var {
        let span = then.down.at.at - now.down.at.at;
        if then.asleep.cuts == now.down.cuts && now.asleep.cuts == now.down.cuts {
            let slope = (then.over.at - now.over.at) / span;
            return now.down.at.plus(now.over.divided_up(-slope));
        }
        if let Some(first) = self.on_the_line(now, then) {
            return first;
        }
        let is_fixed = [now, then].iter().all(|it| it.down.at.is_fixed() && it.over.is_fixed());
        // The bounds hold whatever is found between them.
        let reach = self.reach;
        let (mut over, mut under) = (0, span);
        while under - over > 1 {
            let middle = over + (under - over) / 2;
            let at = now.down.at.later(middle);
            let cursor = self.think(now.down, at, self.problem.computer.awake);
            if self.attempt(cursor).over.at <= 0 { under = middle } else { over = middle }
        }
        self.reach = reach;
        // Where neither end moves, nor how far it is over there, nothing between
        // them does.
        if is_fixed {
            return now.down.at.later(under);
        }
        Var::between(now.down.at.at + under, now.down.at.later(1), then.down.at)
    }

    /// The same where the capacity cuts off what the shutdown still brings, and
    /// no longer does at `then`: at the maximum, which is below it, nothing is cut
    /// off, and from there to `then` it is a straight line.
    fn on_the_line(&self, now: Try, then: Try) -> Option<Var> {
        let battery = self.problem.battery;
        let gain = if now.shrinks { battery.idle.max(0) } else { 0 };
        let net = self.energy.net(&now.down, self.problem.computer.awake);
        let is_line = then.asleep.cuts == now.down.cuts;
        let is_straight = now.down.is_straight_to(&now.asleep);
        (is_line && is_straight && net < 0).then(|| {
            let under = then.over.times(-1);
            then.down.at.minus(under.divided(gain - net))
        })
    }
}
