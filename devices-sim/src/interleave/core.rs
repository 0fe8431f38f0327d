//! The interleaver's books: who can run, who waits for what, and what time it
//! is. Lives in a thread-local while a run lasts, so that a switch point deep
//! inside a driver needs no handle.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};

use faregate_tickets::clock::{Clock, Instant};
use faregate_tickets::id::Priority;

use super::report::{End, Over, Switch};
use super::schedule::Schedule;
use crate::clock::SimClock;
use crate::random::{Dice, mix};

thread_local! {
    static CORE: RefCell<Option<Core>> = const { RefCell::new(None) };
    static THREAD: usize = fresh_id();
}

/// So many choices without any time passing mean that the bodies spin.
const CHOICES_PER_INSTANT_MAX: u32 = 50_000;
/// A body that is chosen so often in a row loses its rank: in a ranked
/// schedule a body that polls must not keep out the one it polls for.
const CHOICES_IN_A_ROW_MAX: u32 = 64;

/// Runs `f` with the books of the run on this thread, if there is one. `f` must
/// not switch: the books are borrowed.
pub(super) fn with<R>(f: impl FnOnce(&mut Core) -> R) -> Option<R> {
    CORE.with_borrow_mut(|core| core.as_mut().map(f))
}

/// Opens the books of a run on this thread.
pub(super) fn open(core: Core) {
    let before = CORE.replace(Some(core));
    assert!(before.is_none(), "an interleaver runs inside another one's body");
}

/// Closes the books.
pub(super) fn close() -> Option<Core> {
    CORE.take()
}

/// A number that no other body and no thread has.
pub(super) fn fresh_id() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// The identity of the running body, or of the thread outside any body.
pub(super) fn current_id() -> usize {
    let body = with(|core| core.running.map(|i| core.bodies[i].id)).flatten();
    body.unwrap_or_else(|| THREAD.with(|id| *id))
}

/// What a body waits for, besides the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    Time,
    /// The lock at this address, held by the body with this id.
    Lock {
        lock: usize,
        holder: usize,
    },
    /// The wake flag at this address.
    Flag(usize),
    /// That anybody does anything after this much progress.
    Progress(u64),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Ready,
    Blocked { cause: Cause, until: Instant },
    Ended,
}

pub(super) struct Body {
    pub(super) name: &'static str,
    pub(super) priority: Priority,
    pub(super) id: usize,
    pub(super) state: State,
    pub(super) end: End,
    /// Whether it was suspended while it unwound.
    pub(super) mid_unwind: bool,
    /// Whether it was ever entered.
    pub(super) begun: bool,
    /// Whether it looks at a condition again, which is no progress.
    polling: bool,
    /// How often it may still try to wait after the run is over.
    grace: u32,
    rank: u64,
}

impl Body {
    pub(super) fn new(name: &'static str, priority: Priority) -> Self {
        Self {
            name,
            priority,
            id: fresh_id(),
            state: State::Ready,
            end: End::Abandoned,
            mid_unwind: false,
            begun: false,
            polling: false,
            grace: 10_000,
            rank: 0,
        }
    }
}

/// What the run does next.
pub(super) enum Next {
    Resume(usize),
    Over(Over),
}

pub(super) struct Core {
    pub(super) clock: SimClock,
    pub(super) bodies: Vec<Body>,
    pub(super) running: Option<usize>,
    pub(super) abandoning: bool,
    pub(super) stopped: bool,
    pub(super) choices: u64,
    pub(super) resumes: u64,
    pub(super) fingerprint: u64,
    pub(super) log: Option<Vec<Switch>>,
    pub(super) progress: u64,
    chosen: Option<usize>,
    horizon: Instant,
    schedule: Schedule,
    dice: Dice,
    choices_this_instant: u32,
    choices_in_a_row: u32,
    lowest_rank: u64,
    candidates: Vec<usize>,
}

impl Core {
    pub(super) fn new(
        clock: SimClock,
        mut bodies: Vec<Body>,
        schedule: Schedule,
        seed: u64,
        horizon: Instant,
    ) -> Self {
        let mut dice = Dice::new(seed, 2);
        for body in &mut bodies {
            body.rank = dice.throw() | 1 << 63;
        }
        Self {
            clock,
            bodies,
            running: None,
            abandoning: false,
            stopped: false,
            choices: 0,
            resumes: 0,
            fingerprint: 0,
            log: None,
            progress: 0,
            chosen: None,
            horizon,
            schedule,
            dice,
            choices_this_instant: 0,
            choices_in_a_row: 0,
            lowest_rank: 1 << 63,
            candidates: Vec::new(),
        }
    }

    /// Decides at a switch point of the running body; true if it goes on.
    pub(super) fn goes_on(&mut self, what: &'static str) -> bool {
        self.note(what);
        if self.spins() || self.stopped {
            return false;
        }
        let next = self.pick();
        if next == self.running {
            return true;
        }
        self.chosen = next;
        false
    }

    /// Puts the running body to sleep.
    pub(super) fn block(&mut self, cause: Cause, until: Instant) {
        if let Some(i) = self.running {
            self.bodies[i].state = State::Blocked { cause, until };
        }
        self.progressed();
    }

    /// The running body did something that others may wait for.
    pub(super) fn progressed(&mut self) {
        if self.running.is_some_and(|i| !self.bodies[i].polling) {
            self.progress += 1;
        }
    }

    /// The running body begins, or ends, to look at a condition again and again.
    pub(super) fn set_polling(&mut self, polling: bool) {
        if let Some(i) = self.running {
            self.bodies[i].polling = polling;
        }
    }

    /// The running body is about to be suspended; says whether it unwinds. This
    /// thread's unwinding is the body's own, unless another one is suspended in
    /// the middle of it.
    pub(super) fn suspend(&mut self, panicking: bool) -> bool {
        let own = panicking && !self.bodies.iter().any(|body| body.mid_unwind);
        if let Some(i) = self.running {
            self.bodies[i].mid_unwind = own;
        }
        own
    }

    /// The running body goes on; says whether the run is over.
    pub(super) fn resumed(&mut self) -> bool {
        if let Some(i) = self.running {
            self.bodies[i].mid_unwind = false;
        }
        self.abandoning
    }

    /// Whether the running body may try to wait once more after the run is over.
    pub(super) fn spend_grace(&mut self) -> bool {
        let Some(i) = self.running else { return true };
        let left = self.bodies[i].grace.checked_sub(1);
        self.bodies[i].grace = left.unwrap_or(0);
        left.is_some()
    }

    /// Wakes those who wait for this lock.
    pub(super) fn unlocked(&mut self, lock: usize) {
        self.wake(|cause| matches!(cause, Cause::Lock { lock: other, .. } if other == lock));
    }

    /// Wakes those who wait for this flag.
    pub(super) fn flagged(&mut self, flag: usize) {
        self.wake(|cause| cause == Cause::Flag(flag));
    }

    fn wake(&mut self, concerned: impl Fn(Cause) -> bool) {
        for body in &mut self.bodies {
            if matches!(body.state, State::Blocked { cause, .. } if concerned(cause)) {
                body.state = State::Ready;
            }
        }
    }

    /// Who runs next; moves the time when everybody waits.
    pub(super) fn next_step(&mut self) -> Next {
        loop {
            if self.stopped {
                return Next::Over(Over::Stopped);
            }
            if self.spins() {
                return Next::Over(Over::Livelocked);
            }
            if let Some(i) = self.chosen.take().or_else(|| self.pick()) {
                return Next::Resume(i);
            }
            if let Some(over) = self.move_time() {
                return Next::Over(over);
            }
        }
    }

    fn move_time(&mut self) -> Option<Over> {
        let wake_times = self.bodies.iter().filter_map(|body| match body.state {
            State::Blocked { until, .. } if until < Instant::FAR_FUTURE => Some(until),
            _ => None,
        });
        match wake_times.min() {
            Some(at) if at <= self.horizon => self.advance(at),
            Some(_) => {
                self.clock.advance_to(self.horizon);
                return Some(Over::Horizon);
            }
            None if self.bodies.iter().all(|body| body.state == State::Ended) => {
                return Some(Over::Finished);
            }
            None => return Some(Over::Stalled),
        }
        None
    }

    fn advance(&mut self, at: Instant) {
        self.clock.advance_to(at);
        self.choices_this_instant = 0;
        self.progress += 1;
        for body in &mut self.bodies {
            if matches!(body.state, State::Blocked { until, .. } if until <= at) {
                body.state = State::Ready;
            }
        }
    }

    fn spins(&self) -> bool {
        self.choices_this_instant > CHOICES_PER_INSTANT_MAX
    }

    fn pick(&mut self) -> Option<usize> {
        self.choices += 1;
        self.choices_this_instant += 1;
        let mut ready = std::mem::take(&mut self.candidates);
        ready.clear();
        ready.extend((0..self.bodies.len()).filter(|&i| self.is_ready(i)));
        let picked = match self.schedule {
            Schedule::Even { stay } => self.pick_evenly(&ready, stay),
            Schedule::Ranked { demote } => self.pick_by_rank(&ready, demote),
            Schedule::Priorities => self.pick_by_priority(&ready),
        };
        self.candidates = ready;
        picked
    }

    fn is_ready(&self, i: usize) -> bool {
        match self.bodies[i].state {
            State::Ready => true,
            State::Blocked { cause: Cause::Progress(seen), .. } => self.progress > seen,
            _ => false,
        }
    }

    fn pick_evenly(&mut self, ready: &[usize], stay: u8) -> Option<usize> {
        let may_stay = self.running.is_some_and(|i| ready.contains(&i));
        if may_stay && self.dice.below(256) < u64::from(stay) {
            return self.running;
        }
        ready.get(self.dice.index(ready.len())).copied()
    }

    fn pick_by_rank(&mut self, ready: &[usize], demote: u8) -> Option<usize> {
        self.choices_in_a_row += 1;
        let falls = self.dice.below(256) < u64::from(demote)
            || self.choices_in_a_row > CHOICES_IN_A_ROW_MAX;
        if let Some(i) = self.running.filter(|_| falls) {
            self.lowest_rank -= 1;
            self.bodies[i].rank = self.lowest_rank;
        }
        let first = ready.iter().copied().max_by_key(|&i| self.bodies[i].rank);
        if first != self.running {
            self.choices_in_a_row = 0;
        }
        first
    }

    /// The most important among those who are ready or stand before a lock; for
    /// the latter, whoever holds it runs.
    fn pick_by_priority(&mut self, ready: &[usize]) -> Option<usize> {
        let level = |i: usize| self.bodies[i].priority.level();
        let boosted =
            (0..self.bodies.len()).filter_map(|i| Some((level(i), self.in_the_way_of(i)?)));
        let top = boosted.clone().map(|(level, _)| level).max()?;
        let first: Vec<usize> =
            boosted.filter(|(level, _)| *level == top).map(|(_, i)| i).collect();
        debug_assert!(first.iter().all(|i| ready.contains(i)));
        Some(first[self.dice.index(first.len())])
    }

    /// The body that must run for body `i` to get on: itself, or at the end of
    /// a chain of locks; nobody if that one sleeps.
    fn in_the_way_of(&self, mut i: usize) -> Option<usize> {
        for _ in 0..self.bodies.len() {
            if self.is_ready(i) {
                return Some(i);
            }
            i = self.holder_before(i)?;
        }
        None
    }

    /// The body that holds the lock which body `i` waits for.
    pub(super) fn holder_before(&self, i: usize) -> Option<usize> {
        let State::Blocked { cause: Cause::Lock { holder, .. }, .. } = self.bodies[i].state else {
            return None;
        };
        self.bodies.iter().position(|body| body.id == holder)
    }

    fn note(&mut self, what: &'static str) {
        let running = self.running.unwrap_or(usize::MAX);
        let at = self.clock.now();
        let text = what.bytes().fold(running as u64, |hash, byte| mix(hash ^ u64::from(byte)));
        self.fingerprint = mix(self.fingerprint ^ at.as_micros()).wrapping_add(text);
        if let (Some(log), Some(body)) = (&mut self.log, self.bodies.get(running)) {
            log.push(Switch { at, body: body.name, what });
        }
    }
}
