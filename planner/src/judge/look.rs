//! Looks at a candidate's world, segment by segment, for what it breaks that
//! the world without it does not, or not so much.

mod soft;

use crate::derive::var::{Reach, Var};
use crate::derive::{After, Late, Leap, Mark, Open, Placed, World};
use crate::energy::{Cursor, Segment, Watch};
use crate::judge::Rest;
use crate::problem::Problem;

/// A limit that depends on what is derived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Soft,
    Handover,
    Peak,
    Computer,
    Lead,
}

/// A limit is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Broken {
    pub(crate) kind: Kind,
    /// When it is broken by the most; of several such instants the first.
    pub(crate) at: i64,
    /// By how much then.
    pub(crate) amount: i64,
}

/// Looks for broken limits.
pub(crate) struct Look<'a> {
    problem: &'a Problem,
    placed: &'a Placed,
    world: &'a World,
    /// How many more changes of what is drawn, and needs, are placed than in the
    /// world: fewer, where that has what is being made longer.
    more: (isize, isize),
    handover: Option<i64>,
    /// Whether to find out how long nothing is broken, too.
    keep: bool,
    /// By how much it can be shifted so that something is broken.
    broken_for: Option<i64>,
    /// Whether everything is to be found.
    lists: bool,
    /// Whether what is placed is counted as in the world without it.
    alike: bool,
    pub(crate) list: Vec<Broken>,
}

impl<'a> Look<'a> {
    pub(crate) fn new(rest: &Rest<'a>, optional: bool, keep: bool) -> Self {
        let Rest { problem, placed, world, plain } = *rest;
        let handover = if optional { problem.handover } else { None };
        let list = Vec::new();
        let (broken_for, lists, alike) = (None, false, !plain);
        let more = world.more_in(placed);
        Self { problem, placed, world, more, handover, keep, broken_for, lists, alike, list }
    }

    /// Finds everything that is broken.
    pub(crate) fn listing(self) -> Self {
        Self { lists: true, ..self }
    }

    /// It is placed already: other things have other numbers than in the world
    /// without it.
    pub(crate) const fn unlike(&mut self) -> &mut Self {
        self.alike = false;
        self
    }

    pub(crate) const fn broken_for(&self) -> Option<i64> {
        self.broken_for
    }

    /// Something is broken, until it is shifted further than this, if all is as
    /// it was up to here.
    pub(crate) fn breaks(&mut self, shift: i64, reach: &Reach) {
        let shift = shift.min(reach.get());
        self.broken_for = self.broken_for.max(Some(shift));
    }

    /// Of each kind the first that is broken by the most.
    fn lists(&mut self, kind: Kind, at: i64, amount: i64) {
        if !self.lists {
            return;
        }
        match self.list.iter_mut().find(|broken| broken.kind == kind) {
            Some(broken) if amount > broken.amount => *broken = Broken { kind, at, amount },
            Some(_) => {}
            None => self.list.push(Broken { kind, at, amount }),
        }
    }

    fn peak(&mut self, segment: &Segment, reach: &mut Reach) {
        let limit = self.problem.peak_limit;
        if segment.peak <= limit {
            return;
        }
        let mut here = Reach::ALL;
        let _ = here.lt(segment.from, segment.to);
        if self.world.peak <= limit {
            self.lists(Kind::Peak, segment.from.at, segment.peak - limit);
            return self.breaks(here.get(), reach);
        }
        let first = self.world.at(segment.from.at);
        let last = self.world.at(segment.to.at - 1);
        let worse = |&piece: &usize| self.world.pieces[piece].peak < segment.peak;
        if let Some(piece) = (first..=last).find(worse) {
            let (from, to) = (self.world.pieces[piece].from, self.world.until(piece));
            let _ = here.lt(segment.from, Var::fixed(to));
            let _ = here.lt(Var::fixed(from), segment.to);
            self.lists(Kind::Peak, segment.from.at.max(from), segment.peak - limit);
            return self.breaks(here.get(), reach);
        }
        self.must_not_move(segment, reach);
    }

    fn handover(&mut self, segment: &Segment, reach: &mut Reach) {
        let Some(at) = self.handover else { return };
        let (from, to) = (segment.from, segment.to);
        let instant = Var::fixed(at);
        let begun = reach.le(from, instant);
        let is_last = to.at == self.problem.end && at == self.problem.end;
        if !begun || !is_last && reach.le(to, instant) {
            return;
        }
        let mut charge = segment.first.plus(instant.minus(from).times(segment.net));
        let capacity = Var::fixed(self.problem.battery.capacity);
        if reach.lt(capacity, charge) {
            charge = capacity;
        }
        let min = self.problem.battery.handover;
        let bound = min.min(self.world.charge(at));
        let mut here = Reach::ALL;
        if !here.is_kept(charge.later(-bound)) {
            self.lists(Kind::Handover, at, min - charge.at);
            self.breaks(here.get(), reach);
        } else if self.keep {
            reach.limit(here.get());
        }
    }

    /// From an instant on there is so much less charge than without the
    /// candidate, and nothing else differs until the leap's end.
    fn less(&mut self, change: Var, from: i64, leap: &Leap, reach: &mut Reach) {
        let battery = &self.problem.battery;
        let (at, least) = leap.lowest;
        self.less_than((Kind::Soft, battery.soft), change, (at, least), reach);
        let is_in = |at: i64| from <= at && leap.to.is_none_or(|to| at < to.cursor.at.at);
        if let Some(at) = self.handover.filter(|&at| is_in(at)) {
            let without = self.world.charge(at);
            self.less_than((Kind::Handover, battery.handover), change, (at, without), reach);
        }
    }

    /// A charge that was `without` changes: whether it is below a minimum, and
    /// lower than it was.
    fn less_than(
        &mut self,
        (kind, min): (Kind, i64),
        change: Var,
        (at, without): (i64, i64),
        reach: &mut Reach,
    ) {
        let bound = min.min(without);
        let mut here = Reach::ALL;
        if !here.is_kept(change.later(without - bound)) {
            self.lists(kind, at, min - without - change.at);
            self.breaks(here.get(), reach);
        } else if self.keep {
            reach.limit(here.get());
        }
    }

    /// What follows is as in the world without the candidate, where the charge
    /// is so much then: up to where the charge makes a difference.
    fn go_on(&mut self, there: &Cursor, charge: Var, reach: &mut Reach) -> After {
        let change = there.charge.minus(charge);
        if change == Var::fixed(0) {
            return After::Over;
        }
        let from = there.at.at;
        let Some(leap) = self.world.leap(from).filter(|_| change.at <= 0) else {
            return After::On;
        };
        let _ = reach.le(change, Var::fixed(0));
        self.less(change, from, &leap, reach);
        leap.to.map_or(After::Over, |to| {
            let mut to = to.changed(change, self.more);
            to.cursor = to.cursor.with_own_of(there);
            After::From(to)
        })
    }

    /// Where it is not worth working out how long a limit is kept.
    fn must_not_move(&self, segment: &Segment, reach: &mut Reach) {
        let all = [segment.from, segment.to, segment.first, segment.last];
        if self.keep && !all.iter().all(|it| it.is_fixed()) {
            reach.limit(0);
        }
    }
}

impl Watch for Look<'_> {
    fn segment(&mut self, segment: &Segment, reach: &mut Reach) {
        self.peak(segment, reach);
        self.handover(segment, reach);
        self.soft(segment, reach);
    }

    fn late(&mut self, late: Late, reach: &Reach) {
        if self.world.has(late) {
            return;
        }
        // Of several the first counts, by however much it is.
        if !self.list.iter().any(|broken| broken.kind == Kind::Lead) {
            self.lists(Kind::Lead, late.at.at, late.by);
        }
        self.breaks(i64::MAX, reach);
    }

    fn asleep(&mut self, mark: &Mark, reach: &mut Reach) -> After {
        let at = mark.cursor.at;
        if !self.alike || !at.is_fixed() {
            return After::On;
        }
        let Some(&here) = self.world.mark_at(at.at) else { return After::On };
        if !here.is_beside(mark, self.more) {
            return After::On;
        }
        self.go_on(&mark.cursor, here.cursor.charge, reach)
    }

    fn compares(&self) -> bool {
        self.alike
    }

    fn knows(&mut self, open: &Open, long: bool, _: &mut Reach) -> bool {
        self.world.has_open(self.problem, self.placed, open, long)
    }

    fn awake(&mut self, open: &Open, reach: &mut Reach) -> After {
        let charge = Var::fixed(self.world.charge(open.until.at));
        self.go_on(&open.cursor, charge, reach)
    }

    /// What is to be kept must still be kept in it, where it comes to last.
    fn empty(&mut self, from: Var, to: Var, reach: &mut Reach) {
        if self.keep {
            let _ = reach.le(to, from);
        }
    }

    /// As soon as nothing that follows could say that it must be shifted
    /// further.
    fn is_done(&self, reach: &Reach) -> bool {
        !self.lists && self.broken_for.is_some_and(|shift| self.keep || shift >= reach.get())
    }
}
