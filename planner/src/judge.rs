//! Whether a candidate can start at an instant, and if not, until when not.

mod look;

use crate::derive::var::Reach;
use crate::derive::{Candidate, Frame, Late, NONE, Own, Placed, Placement, Sweep, World};
use crate::problem::Problem;

use look::Look;
pub(crate) use look::{Broken, Kind};

/// What a candidate is compared with: everything else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) placed: &'a Placed,
    pub(crate) world: &'a World,
}

/// What is so of a candidate at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It keeps every limit, and does so if it is shifted by this much.
    Fits(i64),
    /// It does not, and does not if it is shifted by this much.
    Breaks(i64),
}

impl Rest<'_> {
    /// Judges by the limits that depend on what is derived: lead, manual
    /// blocks, peak, charge.
    ///
    /// # Timing
    ///
    /// In proportion to everything that is placed.
    pub(crate) fn judge(&self, candidate: Candidate, optional: bool, keep: bool) -> Verdict {
        let mut reach = Reach::ALL;
        let Ok(own) = Own::of(self.problem, self.placed, candidate, &mut reach) else {
            return Verdict::Breaks(reach.get());
        };
        if own.late.iter().any(|&late| !self.world.has(late)) {
            return Verdict::Breaks(reach.get());
        }
        let frame = Frame { placed: self.placed, own: &own };
        let mut look = Look::new(self.problem, self.world, optional, keep);
        let before = own.first().and_then(|first| self.world.mark_before(self.problem, first));
        let mut sweep = Sweep::new(self.problem, frame, reach, &mut look);
        match before {
            Some(mark) => sweep.go_on(&mark),
            None => sweep.run(),
        }
        let reach = sweep.reach;
        match look.broken_for() {
            Some(shift) => Verdict::Breaks(shift),
            None => Verdict::Fits(reach.get()),
        }
    }

    /// Everything that it breaks at that time, of what depends on what is
    /// derived.
    pub(crate) fn breaks(&self, slot: Placement, optional: bool) -> Vec<Broken> {
        let mut placed = self.placed.clone();
        placed.insert(self.problem, slot);
        let mut look = Look::new(self.problem, self.world, optional, false).listing();
        let frame = Frame { placed: &placed, own: &NONE };
        let mut sweep = Sweep::new(self.problem, frame, Reach::ALL, &mut look);
        sweep.run();
        let mut broken = look.list;
        let with = World::of(self.problem, &placed);
        let new = |late: &&Late| !self.world.has(**late);
        if let Some(late) = with.late.iter().find(new) {
            broken.push(Broken { kind: Kind::Lead, at: late.at.at, amount: late.by });
        }
        broken.extend(self.in_blocks(slot, &placed));
        broken
    }

    /// Where it, or what is heated because of it, meets a manual shutdown.
    fn in_blocks(&self, slot: Placement, with: &Placed) -> Vec<Broken> {
        let zones = with.zones.iter().zip(&self.placed.zones);
        let heats = zones.flat_map(|(with, without)| {
            let heats = with.heats.iter().flatten();
            heats.filter(|heat| !without.heats.iter().flatten().any(|old| old == *heat))
        });
        let spans = heats.map(|heat| (heat.from, heat.to)).chain([(slot.start, slot.end)]);
        let spans: Vec<_> = spans.filter(|(from, to)| from < to).collect();
        let meets = self.problem.blocks.iter().flat_map(|block| {
            let both = spans.iter().map(|(from, to)| (block.from.max(*from), block.to.min(*to)));
            both.filter(|(from, to)| from < to).min()
        });
        meets.map(|(at, to)| Broken { kind: Kind::Computer, at, amount: to - at }).collect()
    }
}

/// Whether a world breaks nothing, of what depends on what is derived, that
/// another one does not, or not so much: but for the minimum at handover, which
/// some may break.
pub(crate) fn keeps(problem: &Problem, (placed, world): (&Placed, &World), other: &World) -> bool {
    let heats = placed.zones.iter().flat_map(|zone| zone.heats.iter().flatten());
    let mut ends = heats.map(|heat| (heat.from, heat.to)).filter(|(from, to)| from < to);
    let blocked = ends
        .any(|(from, to)| problem.blocks.iter().any(|block| from < block.to && block.from < to));
    if blocked || world.late.iter().any(|&late| !other.has(late)) {
        return false;
    }
    let mut look = Look::new(problem, other, false, false).listing();
    Sweep::new(problem, Frame { placed, own: &NONE }, Reach::ALL, &mut look).run();
    look.list.is_empty()
}
