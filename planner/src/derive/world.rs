//! The world that follows from what is placed, kept to compare others with.

use crate::energy::{Segment, Watch};
use crate::problem::Problem;

use super::awake::{Phase, Sweep};
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
        world
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
    }
}
