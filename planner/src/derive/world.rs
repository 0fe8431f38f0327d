//! The world that follows from what is placed, kept to compare others with.

use crate::energy::{Segment, Watch};
use crate::problem::Problem;

use super::awake::Sweep;
use super::mark::{After, Mark, Phase};
use super::own::{Frame, Late, NONE};
use super::placed::{Placed, Who};
use super::var::{Reach, Var};

/// The charge in a straight line from an instant on, up to the capacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    pub(crate) from: i64,
    pub(crate) charge: i64,
    pub(crate) net: i64,
    pub(crate) peak: i64,
}

/// What follows from what is placed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct World {
    /// In order, without gaps; the last is where the plan ends.
    pub(crate) pieces: Vec<Piece>,
    pub(crate) phases: Vec<Phase>,
    pub(crate) late: Vec<Late>,
    capacity: i64,
    /// The largest sum of peaks.
    pub(crate) peak: i64,
    /// Where the computer falls asleep.
    pub(super) marks: Vec<Mark>,
    /// Where what follows depends on the charge, in order.
    pub(super) depends: Vec<i64>,
    /// For each piece, the one that begins with the lowest charge from it on,
    /// up to where a [leap](Self::leap) ends; of several the first.
    lowest: Vec<usize>,
    /// How many changes of what is drawn, and needs, it was made from.
    counts: (usize, usize),
}

/// From an instant on nothing depends on the charge, as long as there is not
/// more of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leap {
    /// Until then; none: to the end.
    pub(crate) to: Option<Mark>,
    /// When the charge is lowest, and how much it is then.
    pub(crate) lowest: (i64, i64),
}

impl World {
    /// From nothing but what is placed.
    pub(crate) fn of(problem: &Problem, placed: &Placed) -> Self {
        let mut world = Self::empty(problem);
        let frame = Frame { placed, own: &NONE };
        Sweep::new(problem, frame, Reach::ALL, &mut world).run();
        world.finished(problem, placed)
    }

    /// How many more changes of what is drawn, and needs, there are in `placed`
    /// than in what it was made from.
    pub(crate) fn more_in(&self, placed: &Placed) -> (isize, isize) {
        let more = |now: usize, then: usize| now.cast_signed() - then.cast_signed();
        (more(placed.steps.len(), self.counts.0), more(placed.needs.len(), self.counts.1))
    }

    pub(super) fn empty(problem: &Problem) -> Self {
        Self { capacity: problem.battery.capacity, ..Self::default() }
    }

    /// The last sleep that begins so early that nothing from an instant on is
    /// looked at before it.
    pub(crate) fn mark_before(&self, problem: &Problem, change: i64) -> Option<&Mark> {
        let computer = &problem.computer;
        let ahead = computer.min_awake + computer.wakeup_time + computer.min_sleep.max(1);
        let early = |mark: &Mark| mark.cursor.at.at < change - ahead;
        let count = self.marks.partition_point(early);
        count.checked_sub(1).map(|last| &self.marks[last])
    }

    /// The sleep that begins then.
    pub(crate) fn mark_at(&self, at: i64) -> Option<&Mark> {
        let found = self.marks.binary_search_by_key(&at, |mark| mark.cursor.at.at);
        found.ok().map(|found| &self.marks[found])
    }

    /// From an instant to the last sleep's begin before which the charge makes
    /// no difference.
    pub(crate) fn leap(&self, from: i64) -> Option<Leap> {
        let next = self.depends.partition_point(|&at| at < from);
        let to = match self.depends.get(next) {
            None => None,
            Some(&at) => Some(*self.mark_until(at).filter(|mark| mark.cursor.at.at > from)?),
        };
        let first = self.pieces.partition_point(|piece| piece.from < from);
        let lowest = &self.pieces[*self.lowest.get(first)?];
        Some(Leap { to, lowest: (lowest.from, lowest.charge) })
    }

    /// Whether what follows depends on the charge somewhere in [from, to).
    pub(crate) fn depends_between(&self, from: i64, to: i64) -> bool {
        let next = self.depends.partition_point(|&at| at < from);
        self.depends.get(next).is_some_and(|&at| at < to)
    }

    /// The phase in which the computer is up all the time between two instants.
    pub(crate) fn phase_over(&self, from: i64, to: i64) -> Option<&Phase> {
        let begun = self.phases.partition_point(|phase| phase.up.at <= from);
        let last = self.phases.get(begun.checked_sub(1)?);
        last.filter(|phase| to <= phase.down.at)
    }

    fn mark_until(&self, at: i64) -> Option<&Mark> {
        let count = self.marks.partition_point(|mark| mark.cursor.at.at <= at);
        count.checked_sub(1).map(|last| &self.marks[last])
    }

    /// Once everything was looked at.
    pub(super) fn finished(mut self, problem: &Problem, placed: &Placed) -> Self {
        if self.pieces.is_empty() {
            self.close(problem.now, problem.battery.charge);
        }
        let swept = core::mem::replace(&mut self.late, late_heats(placed));
        self.late.extend(swept);
        self.late.dedup_by_key(|late| (late.at.at, late.who));
        self.counts = (placed.steps.len(), placed.needs.len());
        self.depends.sort();
        self.depends.dedup();
        self.lowest = self.lowest_pieces();
        self
    }

    /// Where leaps end, from the last to the first.
    fn ends(&self) -> impl Iterator<Item = i64> {
        let ends = self.depends.iter().rev().filter_map(|&at| self.mark_until(at));
        ends.map(|mark| mark.cursor.at.at)
    }

    /// From the end to the begin: a leap ends at the last sleep before a
    /// dependence.
    fn lowest_pieces(&self) -> Vec<usize> {
        let mut ends = self.ends().peekable();
        let mut lowest = vec![0; self.pieces.len()];
        let mut least = self.pieces.len().saturating_sub(1);
        for (at, piece) in self.pieces.iter().enumerate().rev() {
            let mut is_end = false;
            while ends.next_if(|&end| end >= piece.from).is_some_and(|end| end == piece.from) {
                is_end = true;
            }
            if is_end || piece.charge <= self.pieces[least].charge {
                least = at;
            }
            lowest[at] = least;
        }
        lowest
    }

    pub(super) fn close(&mut self, at: i64, charge: i64) {
        self.pieces.push(Piece { from: at, charge, net: 0, peak: 0 });
    }

    /// The index of the piece that holds from `at` on.
    pub(crate) fn at(&self, at: i64) -> usize {
        self.pieces.partition_point(|piece| piece.from <= at).saturating_sub(1)
    }

    /// The charge at an instant, from now to the end.
    pub(crate) fn charge(&self, at: i64) -> i64 {
        self.charge_in(self.at(at), at)
    }

    /// The same, where the piece is known.
    pub(crate) fn charge_in(&self, piece: usize, at: i64) -> i64 {
        let piece = &self.pieces[piece];
        (piece.charge + piece.net * (at - piece.from)).min(self.capacity)
    }

    /// The last instant of a piece at which nothing is cut off, and the next
    /// one, where that lies in it.
    pub(crate) fn cut(&self, piece: usize) -> Option<(i64, i64)> {
        let it = &self.pieces[piece];
        let next = self.pieces.get(piece + 1)?;
        if it.net <= 0 || next.charge < self.capacity {
            return None;
        }
        let last = it.from + (self.capacity - it.charge) / it.net;
        (last < next.from).then_some((last, last + 1))
    }

    /// The end of a piece: the next one's begin.
    pub(crate) fn until(&self, piece: usize) -> i64 {
        self.pieces.get(piece + 1).map_or(i64::MAX, |next| next.from)
    }

    /// Whether this was so, too.
    pub(crate) fn has(&self, late: Late) -> bool {
        self.late.iter().any(|it| it.at == late.at && it.who == late.who)
    }
}

/// Heating that should have begun before now.
pub(crate) fn late_heats(placed: &Placed) -> Vec<Late> {
    let heats = placed.zones.iter().flat_map(|zone| zone.heats.iter().flatten());
    let late = heats.filter(|heat| heat.late > 0);
    late.map(|heat| Late { at: Var::fixed(heat.to), who: Who::Item(heat.item), by: heat.late })
        .collect()
}

impl Watch for World {
    fn segment(&mut self, segment: &Segment, _: &mut Reach) {
        if let Some(last) = self.pieces.last()
            && last.from == segment.from.at
        {
            self.pieces.pop();
        }
        let (from, charge) = (segment.from.at, segment.first.at);
        self.pieces.push(Piece { from, charge, net: segment.net, peak: segment.peak });
        self.peak = self.peak.max(segment.peak);
        self.close(segment.to.at, segment.last.at);
        let uncut = charge + segment.net * (segment.to.at - from);
        if uncut > segment.last.at {
            self.depends.push(segment.to.at - 1);
        }
    }

    fn late(&mut self, late: Late, _: &Reach) {
        self.depends.push(late.at.at);
        self.late.push(late);
    }

    fn depends(&mut self, at: i64) {
        self.depends.push(at);
    }

    fn phase(&mut self, phase: Phase) {
        self.phases.push(phase);
    }

    fn asleep(&mut self, mark: &Mark, _: &mut Reach) -> After {
        self.marks.push(*mark);
        After::On
    }
}
