//! The battery's charge, in exact integers: a milliwatt for a millisecond is a
//! microjoule.
//!
//! Between two changes of what is drawn the charge is a straight line, cut off
//! at the capacity; what comes in beyond is lost.

use crate::derive::var::{Reach, Var};
use crate::derive::{After, Frame, Late, Mark, Open, OwnStep, Phase, Piece};
use crate::problem::{Draw, Problem};

/// An instant, the charge then, and what is drawn from then on beside the
/// computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cursor {
    pub(crate) at: Var,
    pub(crate) charge: Var,
    drawn: Draw,
    /// How many changes are behind, of those that are placed and of the
    /// candidate's.
    placed: usize,
    own: usize,
    /// How often the capacity cut something off.
    pub(crate) cuts: u32,
}

/// A time in which nothing changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub(crate) from: Var,
    pub(crate) to: Var,
    pub(crate) first: Var,
    pub(crate) last: Var,
    /// What comes in, less what is drawn.
    pub(crate) net: i64,
    pub(crate) peak: i64,
}

/// Who looks at the segments, in order.
pub(crate) trait Watch {
    /// The next one. It is never empty at present.
    fn segment(&mut self, segment: &Segment, reach: &mut Reach);

    /// One that is empty at present.
    fn empty(&mut self, _from: Var, _to: Var, _reach: &mut Reach) {}

    /// Something should have begun earlier than it can.
    fn late(&mut self, _late: Late, _reach: &Reach) {}

    /// What follows depends on how much charge there is at this instant, and not
    /// only on what is drawn.
    fn depends(&mut self, _at: i64) {}

    /// The computer was up.
    fn phase(&mut self, _phase: Phase) {}

    /// The computer has just fallen asleep, and all that a candidate changes is
    /// behind.
    fn asleep(&mut self, _mark: &Mark, _reach: &mut Reach) -> After {
        After::On
    }

    /// Whether anything is known of another world.
    fn compares(&self) -> bool {
        false
    }

    /// The computer is up, and all that a candidate changes is behind. Whether
    /// it is known what follows; it was up for `long` enough.
    fn knows(&mut self, _open: &Open, _long: bool, _reach: &mut Reach) -> bool {
        false
    }

    /// It was known.
    fn awake(&mut self, _open: &Open, _reach: &mut Reach) -> After {
        After::On
    }

    /// Whether nothing that follows matters.
    fn is_done(&self, _reach: &Reach) -> bool {
        false
    }
}

/// Nobody.
pub(crate) struct Unwatched;

impl Watch for Unwatched {
    fn segment(&mut self, _: &Segment, _: &mut Reach) {}
}

/// Charge over time, for what is placed and a candidate's own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Energy<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) frame: Frame<'a>,
}

impl Energy<'_> {
    /// At the present instant, before anything that begins then.
    pub(crate) const fn start(&self) -> Cursor {
        Cursor {
            at: Var::fixed(self.problem.now),
            charge: Var::fixed(self.problem.battery.charge),
            drawn: Draw { marginal: 0, peak: 0 },
            placed: 0,
            own: 0,
            cuts: 0,
        }
    }

    /// Up to an instant, with this drawn by the computer.
    pub(crate) fn walk(
        &self,
        mut cursor: Cursor,
        to: Var,
        computer: Draw,
        reach: &mut Reach,
        watch: &mut impl Watch,
    ) -> Cursor {
        while let Some(step) = self.next(&cursor, reach)
            && reach.le(step.at, to)
        {
            self.pass(&mut cursor, step.at, computer, reach, watch);
            if watch.is_done(reach) {
                return cursor;
            }
            cursor.take(step);
        }
        self.pass(&mut cursor, to, computer, reach, watch);
        cursor
    }

    /// The next change of what is drawn.
    pub(crate) fn next(&self, cursor: &Cursor, reach: &mut Reach) -> Option<Change> {
        let placed = self.frame.placed.steps.get(cursor.placed);
        let own = self.frame.own.steps.get(cursor.own);
        let placed = placed.map(|step| Change {
            at: Var::fixed(step.at),
            draw: Draw { marginal: step.marginal, peak: step.peak },
            own: false,
        });
        let own = own.map(|&OwnStep { at, draw }| Change { at, draw, own: true });
        match (placed, own) {
            (Some(placed), Some(own)) => {
                Some(if reach.le(placed.at, own.at) { placed } else { own })
            }
            (placed, own) => placed.or(own),
        }
    }

    /// What comes in with this drawn by the computer.
    pub(crate) fn net(&self, cursor: &Cursor, computer: Draw) -> i64 {
        self.problem.battery.idle - cursor.drawn.marginal - computer.marginal
    }

    fn pass(
        &self,
        cursor: &mut Cursor,
        to: Var,
        computer: Draw,
        reach: &mut Reach,
        watch: &mut impl Watch,
    ) {
        let net = self.net(cursor, computer);
        let mut charge = cursor.charge.plus(to.minus(cursor.at).times(net));
        let capacity = Var::fixed(self.problem.battery.capacity);
        if net > 0 && !reach.le(charge, capacity) {
            charge = capacity;
            cursor.cuts += 1;
        }
        if cursor.at.at < to.at {
            let peak = cursor.drawn.peak + computer.peak;
            let (from, first) = (cursor.at, cursor.charge);
            watch.segment(&Segment { from, to, first, last: charge, net, peak }, reach);
        } else {
            watch.empty(cursor.at, to, reach);
        }
        cursor.at = to;
        cursor.charge = charge;
    }
}

/// A change of what is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) at: Var,
    draw: Draw,
    own: bool,
}

impl Cursor {
    /// At the begin of a piece, with this drawn by the computer, and so many
    /// changes behind.
    pub(crate) fn at(piece: &Piece, computer: Draw, problem: &Problem, placed: usize) -> Self {
        let drawn = Draw {
            marginal: problem.battery.idle - computer.marginal - piece.net,
            peak: piece.peak - computer.peak,
        };
        let (at, charge) = (Var::fixed(piece.from), Var::fixed(piece.charge));
        Self { at, charge, drawn, placed, own: 0, cuts: 0 }
    }

    /// Whether all of a candidate's changes are behind.
    pub(crate) const fn is_past(&self, own: &[OwnStep]) -> bool {
        self.own == own.len()
    }

    /// Whether no change lies between this one and a later one.
    pub(crate) const fn is_straight_to(&self, later: &Self) -> bool {
        self.placed == later.placed && self.own == later.own
    }

    /// Whether the same of what is placed is behind, at the same instant, where
    /// the other one counts so many more changes.
    pub(crate) fn is_beside(&self, other: &Self, more: isize) -> bool {
        let same = self.placed.checked_add_signed(more) == Some(other.placed);
        self.at == other.at && same && self.drawn == other.drawn
    }

    /// The same with as many of a candidate's changes behind as there.
    pub(crate) const fn with_own_of(self, other: &Self) -> Self {
        Self { own: other.own, ..self }
    }

    /// The same with so much more charge, where there are so many more changes.
    pub(crate) fn changed(self, charge: Var, more: isize) -> Self {
        let placed = self.placed.saturating_add_signed(more);
        Self { charge: self.charge.plus(charge), placed, ..self }
    }

    /// The same where the capacity cut something off so often `there`, and not
    /// as often as `here`.
    pub(crate) const fn with_cuts(self, here: u32, there: u32) -> Self {
        Self { cuts: self.cuts + there - here, ..self }
    }

    const fn take(&mut self, step: Change) {
        self.drawn.marginal += step.draw.marginal;
        self.drawn.peak += step.draw.peak;
        if step.own {
            self.own += 1;
        } else {
            self.placed += 1;
        }
    }
}
