//! A world made anew after a change of what is placed, from the sleep before it
//! on; and only where something is otherwise: what lies between is carried over
//! from the old world, with more or less charge.

use crate::energy::{Segment, Watch};
use crate::problem::Problem;

use super::awake::Sweep;
use super::mark::{After, Mark, Phase};
use super::own::{Frame, Late, NONE, Own};
use super::placed::Placed;
use super::var::Reach;
use super::world::{Piece, World};

/// Between which instants what is placed changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Change {
    pub(crate) first: i64,
    pub(crate) last: i64,
}

impl Change {
    /// By what a candidate adds and takes away; none: nothing changes.
    pub(crate) fn of(own: &Own) -> Option<Self> {
        let steps = own.steps.iter().map(|step| step.at.at);
        let needs = own.needs.iter().flat_map(|need| [need.from.at, need.to.at]);
        let gone = own.gone.iter().flat_map(|need| [need.from, need.to]);
        let all = steps.chain(needs).chain(gone);
        let last = all.max()?;
        own.first().map(|first| Self { first, last })
    }
}

/// The new world as far as it is known, and the old one.
struct Renewal {
    new: World,
    old: World,
    last: i64,
    /// How many more changes of what is drawn, and needs, there are now.
    more: (isize, isize),
}

impl World {
    /// The same as [`World::of`], where this was so before a change.
    ///
    /// # Timing
    ///
    /// A sweep over what is near the change, and over each time in which the
    /// old world depends on the charge; the rest is copied.
    pub(crate) fn after(self, problem: &Problem, placed: &Placed, change: Change) -> Self {
        if !self.late.is_empty() {
            return Self::of(problem, placed);
        }
        let mark = self.mark_before(problem, change.first).copied();
        let more = self.more_in(placed);
        let new = self.head(problem, mark.as_ref());
        let mut renewal = Renewal { new, old: self, last: change.last, more };
        let frame = Frame { placed, own: &NONE };
        let mut sweep = Sweep::new(problem, frame, Reach::ALL, &mut renewal);
        match mark {
            Some(mark) => sweep.go_on(&mark),
            None => sweep.run(),
        }
        let mut new = renewal.new;
        new.peak = new.pieces.iter().map(|piece| piece.peak).max().unwrap_or(0);
        new.finished(problem, placed)
    }

    /// What lies before a sleep.
    fn head(&self, problem: &Problem, mark: Option<&Mark>) -> Self {
        let mut new = Self::empty(problem);
        let Some(mark) = mark else { return new };
        let (at, charge) = (mark.cursor.at.at, mark.cursor.charge.at);
        new.pieces.reserve(self.pieces.len() + 8);
        new.pieces.extend_from_slice(&self.pieces[..self.at(at)]);
        new.close(at, charge);
        new.phases.extend_from_slice(&self.phases[..mark.phases]);
        let marks = self.marks.partition_point(|old| old.cursor.at.at <= at);
        new.marks.extend_from_slice(&self.marks[..marks]);
        let depends = self.depends.partition_point(|&depends| depends < at);
        new.depends.extend_from_slice(&self.depends[..depends]);
        new
    }
}

impl Renewal {
    /// Takes over what the old world has from a sleep to another, or to the end.
    fn carry(&mut self, here: &Mark, there: &Mark, to: Option<&Mark>) -> After {
        let change = there.cursor.charge.at - here.cursor.charge.at;
        let first = self.old.at(here.cursor.at.at);
        let last = to.map_or(self.old.pieces.len(), |to| self.old.at(to.cursor.at.at));
        let moved = |piece: &Piece| Piece { charge: piece.charge + change, ..*piece };
        self.new.pieces.pop();
        self.new.pieces.extend(self.old.pieces[first..last].iter().map(moved));
        let (begin, end) = (here.cursor.at.at, to.map_or(i64::MAX, |to| to.cursor.at.at));
        let phases = to.map_or(self.old.phases.len(), |to| to.phases);
        self.new.phases.extend_from_slice(&self.old.phases[here.phases..phases]);
        let (here, there) = (*here, *there);
        let carried = |mark: &Mark| mark.carried(&here, &there, self.more);
        let marks = |until: i64| self.old.marks.partition_point(|old| old.cursor.at.at <= until);
        let passed = self.old.marks[marks(begin)..marks(end)].iter();
        self.new.marks.extend(passed.map(carried));
        let Some(to) = to else { return After::Over };
        self.new.close(to.cursor.at.at, to.cursor.charge.at + change);
        After::From(carried(to))
    }
}

impl Watch for Renewal {
    fn segment(&mut self, segment: &Segment, reach: &mut Reach) {
        self.new.segment(segment, reach);
    }

    fn late(&mut self, late: Late, reach: &Reach) {
        self.new.late(late, reach);
    }

    fn depends(&mut self, at: i64) {
        self.new.depends(at);
    }

    fn phase(&mut self, phase: Phase) {
        self.new.phase(phase);
    }

    fn asleep(&mut self, mark: &Mark, reach: &mut Reach) -> After {
        let _ = self.new.asleep(mark, reach);
        let at = mark.cursor.at.at;
        let Some(old) = self.old.mark_at(at).copied() else { return After::On };
        if at <= self.last || !old.is_beside(mark, self.more) {
            return After::On;
        }
        let more = mark.cursor.charge.at - old.cursor.charge.at;
        match self.old.leap(at).filter(|_| more <= 0) {
            Some(leap) => self.carry(&old, mark, leap.to.as_ref()),
            None => After::On,
        }
    }
}
