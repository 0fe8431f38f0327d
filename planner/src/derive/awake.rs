//! When the computer is up, as it follows from what needs it and from the
//! charge: from left to right, in one sweep.

use crate::energy::{Cursor, Energy, Unwatched, Watch};
use crate::problem::{Draw, Problem};
use crate::state::Mode;

use super::mark::{Mark, Open, Phase, Up};
use super::own::{Frame, Late};
use super::placed::Who;
use super::var::{Reach, Var};

/// A sleep whose end is looked for.
#[derive(Clone, Copy)]
enum Sleep {
    /// It is in progress now.
    InProgress,
    /// It begins; up to then it is known not to pass the maximum.
    Begins(Option<Var>),
}

/// How a sleep ends.
enum Wake {
    Up(Up),
    /// With the plan.
    Never,
    /// It must not begin.
    Stay,
}

/// How a phase ends.
enum Down {
    At(Var, Option<Up>),
    /// Not before the next need.
    Later,
    /// Not at all.
    Never,
}

/// From now to the end.
pub(crate) struct Sweep<'a, 'w, W> {
    problem: &'a Problem,
    energy: Energy<'a>,
    pub(crate) reach: Reach,
    watch: &'w mut W,
    cursor: Cursor,
    /// How many needs are met, of those that are placed and of the candidate's.
    met: (usize, usize),
    /// How many phases are over.
    phases: usize,
    /// Nothing that follows need be looked at.
    is_over: bool,
}

impl<'a, 'w, W: Watch> Sweep<'a, 'w, W> {
    pub(crate) fn new(
        problem: &'a Problem,
        frame: Frame<'a>,
        reach: Reach,
        watch: &'w mut W,
    ) -> Self {
        let energy = Energy { problem, frame };
        let cursor = energy.start();
        Self { problem, energy, reach, watch, cursor, met: (0, 0), phases: 0, is_over: false }
    }

    /// All of it.
    pub(crate) fn run(&mut self) {
        // Everything that begins now has begun.
        self.cursor = self.think(self.cursor, self.cursor.at, Draw::default());
        let up = self.first();
        self.run_from(up);
    }

    /// What comes after a sleep's begin, up to which nothing differs.
    pub(crate) fn go_on(&mut self, mark: &Mark) {
        let up = self.leap(mark);
        self.run_from(up);
    }

    /// What comes after an instant in a phase, up to which nothing differs.
    pub(crate) fn go_on_in(&mut self, open: &Open) {
        self.cursor = open.cursor;
        (self.met.0, self.phases) = (open.met, open.phases);
        let up = self.stay(open.begun, open.until);
        self.run_from(up);
    }

    /// To a sleep's begin, whatever lies before it.
    fn leap(&mut self, mark: &Mark) -> Option<Up> {
        self.cursor = mark.cursor.with_own_of(&self.cursor);
        (self.met.0, self.phases) = (mark.met, mark.phases);
        match self.wake(self.cursor, self.cursor.at, Sleep::Begins(None)) {
            Wake::Up(up) => Some(self.sleep(up)),
            Wake::Never | Wake::Stay => None,
        }
    }

    fn run_from(&mut self, mut up: Option<Up>) {
        while let Some(begun) = up
            && !self.is_done()
        {
            up = self.phase(begun);
        }
        if !self.is_done() {
            self.go(self.end(), Draw::default());
        }
    }

    fn is_done(&self) -> bool {
        self.is_over || self.watch.is_done(&self.reach)
    }

    const fn end(&self) -> Var {
        Var::fixed(self.problem.end)
    }

    /// What nothing that is in progress can go past: the next manual block, or
    /// the end.
    fn barrier(&self, from: Var) -> Var {
        let block = self.problem.next_block(from.at).map(|block| block.from);
        Var::fixed(block.unwrap_or(self.problem.end))
    }

    fn go(&mut self, to: Var, computer: Draw) {
        self.cursor = self.energy.walk(self.cursor, to, computer, &mut self.reach, self.watch);
    }

    /// The same without anybody looking.
    fn think(&mut self, from: Cursor, to: Var, computer: Draw) -> Cursor {
        self.energy.walk(from, to, computer, &mut self.reach, &mut Unwatched)
    }

    fn max(&mut self, a: Var, b: Var) -> Var {
        if self.reach.le(a, b) { b } else { a }
    }

    fn min(&mut self, a: Var, b: Var) -> Var {
        if self.reach.le(a, b) { a } else { b }
    }

    fn is_late(&mut self, late: Late) {
        self.watch.late(late, &self.reach);
    }

    /// From the computer's present mode on.
    fn first(&mut self) -> Option<Up> {
        let computer = self.problem.computer;
        let now = Var::fixed(self.problem.now);
        if let Some(&block) = self.problem.present_block() {
            return self.through(Var::fixed(block.to));
        }
        let mut since = Var::fixed(computer.since);
        match computer.mode {
            Mode::Awake => return Some(Up { wakeup: now, up: now, counted: since }),
            Mode::WakingUp => {
                let up = self.max(now, since.later(computer.wakeup_time));
                let up = self.min(up, self.barrier(now));
                return Some(Up { wakeup: now, up, counted: up });
            }
            Mode::ShuttingDown => {
                since = since.later(computer.shutdown_time);
                let asleep = self.max(now, since);
                let asleep = self.min(asleep, self.barrier(now));
                self.go(asleep, computer.shutdown);
            }
            Mode::Asleep => {}
        }
        match self.wake(self.cursor, since, Sleep::InProgress) {
            Wake::Up(up) => Some(self.sleep(up)),
            Wake::Never | Wake::Stay => None,
        }
    }

    /// Sleeps until then.
    fn sleep(&mut self, up: Up) -> Up {
        self.go(up.wakeup, Draw::default());
        up
    }

    /// Through a manual block, which ends then.
    fn through(&mut self, to: Var) -> Option<Up> {
        self.go(to, Draw::default());
        (to.at < self.problem.end).then_some(Up { wakeup: to, up: to, counted: to })
    }

    /// An awake phase; what follows after the sleep after it.
    fn phase(&mut self, begun: Up) -> Option<Up> {
        self.go(begun.up, self.problem.computer.wakeup);
        self.stay(begun, begun.up)
    }

    /// The computer stays up until then at least.
    fn stay(&mut self, begun: Up, mut until: Var) -> Option<Up> {
        let computer = self.problem.computer;
        loop {
            if let Some(after) = self.compare_open(begun, until) {
                return after.and_then(|mark| self.leap(&mark));
            }
            let down = self.max(until, begun.counted.later(computer.min_awake));
            let need = self.need();
            let mut absorbs = false;
            if let Some(need) = need {
                let gap = self.wakeup_for(need).minus(down.later(computer.shutdown_time));
                absorbs = self.reach.le(need.from, until)
                    || self.reach.lt(gap, Var::fixed(computer.min_sleep));
            }
            if !absorbs {
                if self.reach.lt(self.end(), down.later(computer.shutdown_time)) {
                    return self.until_the_end(begun);
                }
                match self.down(down, need) {
                    Down::Never => return self.until_the_end(begun),
                    Down::At(down, next) => return self.close(begun, down, next),
                    Down::Later => {}
                }
            }
            let Some(need) = need else { return self.until_the_end(begun) };
            self.meet(need);
            if need.who == Who::Block {
                return self.before_block(begun, need.from);
            }
            if need.who != Who::Present && self.reach.lt(need.from, begun.up) {
                let by = begun.up.at - need.from.at;
                self.is_late(Late { at: need.from, who: need.who, by });
            }
            until = self.max(until, need.to);
        }
    }

    fn until_the_end(&mut self, begun: Up) -> Option<Up> {
        let end = self.end();
        self.go(end, self.problem.computer.awake);
        self.ends(begun, end, end);
        None
    }

    fn before_block(&mut self, begun: Up, from: Var) -> Option<Up> {
        self.go(from, self.problem.computer.awake);
        self.ends(begun, from, from);
        let to = self.problem.next_block(from.at).map_or(self.problem.end, |block| block.to);
        self.through(Var::fixed(to))
    }

    fn close(&mut self, begun: Up, down: Var, next: Option<Up>) -> Option<Up> {
        let computer = self.problem.computer;
        let asleep = down.later(computer.shutdown_time);
        self.go(down, computer.awake);
        self.go(asleep, computer.shutdown);
        self.ends(begun, down, asleep);
        match self.compare() {
            Some(after) => after.and_then(|mark| self.leap(&mark)),
            None => next.map(|up| self.sleep(up)),
        }
    }

    fn ends(&mut self, begun: Up, down: Var, asleep: Var) {
        self.watch.phase(Phase { wakeup: begun.wakeup, up: begun.up, down, asleep });
        self.phases += 1;
    }
}

#[path = "compare.rs"]
mod compare;
#[path = "down.rs"]
mod down;
#[path = "needs.rs"]
mod needs;
#[path = "wake.rs"]
mod wake;
