//! The world that follows from what is placed, kept to compare others with.

use crate::energy::{Segment, Watch};
use crate::problem::Problem;

use super::awake::{Mark, Phase, Sweep};
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
    marks: Vec<Mark>,
    /// Where what follows depends on the charge, in order.
    depends: Vec<i64>,
    /// For each piece, the lowest charge from its begin to the end.
    least: Vec<i64>,
}

/// What a world is from an instant on, if less charge makes no difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quiet {
    pub(crate) from: i64,
    /// The charge then.
    pub(crate) charge: i64,
    /// The lowest charge from then on.
    pub(crate) least: i64,
}

impl World {
    /// From nothing but what is placed.
    pub(crate) fn of(problem: &Problem, placed: &Placed) -> Self {
        let mut world = Self { capacity: problem.battery.capacity, ..Self::default() };
        let frame = Frame { placed, own: &NONE };
        let mut sweep = Sweep::new(problem, frame, Reach::ALL, &mut world);
        sweep.run();
        let (phases, late) = (sweep.phases, sweep.late);
        world.phases = phases;
        world.late = late_heats(placed);
        world.late.extend(late);
        world.late.dedup_by_key(|late| (late.at.at, late.who));
        if world.pieces.is_empty() {
            world.close(problem.now, problem.battery.charge);
        }
        world.finish();
        world
    }

    /// The same as [`World::of`], where nothing has changed before an instant.
    pub(crate) fn after(self, problem: &Problem, placed: &Placed, change: i64) -> Self {
        let Some(mark) = self.mark_before(problem, change).filter(|_| self.late.is_empty()) else {
            return Self::of(problem, placed);
        };
        let mut world = self;
        let (at, charge) = (mark.cursor.at.at, mark.cursor.charge.at);
        world.pieces.truncate(world.pieces.partition_point(|piece| piece.from < at));
        world.close(at, charge);
        world.peak = world.pieces.iter().map(|piece| piece.peak).max().unwrap_or(0);
        world.phases.truncate(mark.phases);
        world.marks.retain(|old| old.cursor.at.at <= at);
        world.depends.retain(|&depends| depends < at);
        let mut before = core::mem::take(&mut world.phases);
        let frame = Frame { placed, own: &NONE };
        let mut sweep = Sweep::new(problem, frame, Reach::ALL, &mut world);
        sweep.phases = core::mem::take(&mut before);
        sweep.go_on(&mark);
        let (phases, late) = (sweep.phases, sweep.late);
        world.phases = phases;
        world.late = late_heats(placed);
        world.late.extend(late);
        world.late.dedup_by_key(|late| (late.at.at, late.who));
        world.finish();
        world
    }

    /// The last sleep that begins so early that nothing from an instant on is
    /// looked at before it.
    pub(crate) fn mark_before(&self, problem: &Problem, change: i64) -> Option<Mark> {
        let computer = &problem.computer;
        let ahead = computer.min_awake + computer.wakeup_time + computer.min_sleep.max(1);
        let early = |mark: &Mark| mark.cursor.at.at < change - ahead;
        let count = self.marks.partition_point(early);
        count.checked_sub(1).map(|last| self.marks[last])
    }

    /// What follows a sleep's begin, if it is there in this world, too, and less
    /// charge then only means as much less charge later.
    pub(crate) fn quiet_from(&self, mark: &Mark) -> Option<Quiet> {
        let from = mark.cursor.at.at;
        let found = self.marks.binary_search_by_key(&from, |mark| mark.cursor.at.at).ok()?;
        let own = &self.marks[found];
        let alike = own.met == mark.met && own.cursor.is_beside(&mark.cursor);
        let quiet = self.depends.last().is_none_or(|&last| last < from);
        let least = *self.least.get(self.at(from))?;
        (alike && quiet).then_some(Quiet { from, charge: own.cursor.charge.at, least })
    }

    fn finish(&mut self) {
        self.depends.sort_unstable();
        self.depends.dedup();
        self.least.clear();
        let mut least = i64::MAX;
        for piece in self.pieces.iter().rev() {
            least = least.min(piece.charge);
            self.least.push(least);
        }
        self.least.reverse();
    }

    fn close(&mut self, at: i64, charge: i64) {
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
fn late_heats(placed: &Placed) -> Vec<Late> {
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
    }

    fn depends(&mut self, at: i64) {
        self.depends.push(at);
    }

    fn asleep(&mut self, mark: &Mark, _: &mut Reach) -> bool {
        self.marks.push(*mark);
        false
    }
}
