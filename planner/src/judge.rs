//! Whether a candidate can start at an instant, and if not, until when not.

mod drained;
mod look;

use crate::derive::var::{Reach, Var};
use crate::derive::{
    Blocked, Candidate, Frame, NONE, Own, Placed, Placement, Sweep, World, late_heats,
};
use crate::energy::Watch;
use crate::problem::Problem;

use look::Look;
pub(crate) use look::{Broken, Kind};

/// What a candidate is compared with: everything else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rest<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) placed: &'a Placed,
    pub(crate) world: &'a World,
    /// Worlds are made from now to the end.
    pub(crate) plain: bool,
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
    /// In proportion to what is placed near it, and to how often what follows
    /// depends on the charge.
    pub(crate) fn judge(&self, candidate: Candidate, optional: bool, keep: bool) -> Verdict {
        let mut reach = Reach::ALL;
        let Ok(own) = Own::of(self.problem, self.placed, candidate, &mut reach) else {
            return Verdict::Breaks(reach.get());
        };
        if own.late.iter().any(|&late| !self.world.has(late)) {
            return Verdict::Breaks(reach.get());
        }
        if own.first().is_none() {
            return Verdict::Fits(reach.get());
        }
        let mut look = Look::new(self, optional, keep);
        let reach = self.sweep(&own, reach, &mut look);
        match look.broken_for() {
            Some(shift) => Verdict::Breaks(shift),
            None => Verdict::Fits(reach.get()),
        }
    }

    /// Looks at what is otherwise with it.
    fn sweep(&self, own: &Own, reach: Reach, look: &mut Look<'_>) -> Reach {
        let frame = Frame { placed: self.placed, own };
        let mut sweep = Sweep::new(self.problem, frame, reach, look);
        let Some(first) = own.first() else { return sweep.reach };
        if self.plain {
            sweep.run();
        } else if let Some(open) = self.world.open_before(self.problem, self.placed, first) {
            sweep.go_on_in(&open);
        } else if let Some(mark) = self.world.mark_before(self.problem, first) {
            sweep.go_on(mark);
        } else {
            sweep.run();
        }
        sweep.reach
    }

    /// Everything that it breaks at that time, of what depends on what is
    /// derived.
    pub(crate) fn breaks(&self, slot: Placement, optional: bool) -> Vec<Broken> {
        let mut look = Look::new(self, optional, false).listing();
        let (start, end) = (Var::fixed(slot.start), Var::fixed(slot.end));
        let candidate = Candidate { item: slot.item, start, end };
        match Own::of(self.problem, self.placed, candidate, &mut { Reach::ALL }) {
            Ok(own) => {
                for &late in &own.late {
                    look.late(late, &Reach::ALL);
                }
                let _ = self.sweep(&own, Reach::ALL, &mut look);
            }
            Err(Blocked) => self.sweep_all(slot, look.unlike()),
        }
        let mut broken = look.list;
        if !self.problem.blocks.is_empty() {
            broken.extend(self.in_blocks(slot));
        }
        broken
    }

    /// From now to the end, with it placed.
    fn sweep_all(&self, slot: Placement, look: &mut Look<'_>) {
        let placed = self.with(slot);
        for late in late_heats(&placed) {
            look.late(late, &Reach::ALL);
        }
        let frame = Frame { placed: &placed, own: &NONE };
        Sweep::new(self.problem, frame, Reach::ALL, look).run();
    }

    fn with(&self, slot: Placement) -> Placed {
        let mut placed = self.placed.clone();
        placed.insert(self.problem, slot);
        placed
    }

    /// Where it, or what is heated because of it, meets a manual shutdown.
    fn in_blocks(&self, slot: Placement) -> Vec<Broken> {
        let with = self.with(slot);
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
    let rest = Rest { problem, placed, world: other, plain: true };
    let mut look = Look::new(&rest, false, false).listing();
    Sweep::new(problem, Frame { placed, own: &NONE }, Reach::ALL, &mut look).run();
    look.list.is_empty()
}
