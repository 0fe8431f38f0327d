//! What a candidate adds to what is placed, and takes away from it.

use crate::problem::{Draw, Problem};

use super::placed::{Need, Placed, Who};
use super::var::{Reach, Var};

/// A change of what is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnStep {
    pub(crate) at: Var,
    pub(crate) draw: Draw,
}

/// The computer must be up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarNeed {
    pub(crate) from: Var,
    pub(crate) to: Var,
    pub(crate) who: Who,
}

/// Something should have begun before now, or before the computer is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Late {
    pub(crate) at: Var,
    pub(crate) who: Who,
    /// By how much.
    pub(crate) by: i64,
}

/// An activity at a time that may shift.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) item: usize,
    pub(crate) start: Var,
    pub(crate) end: Var,
}

/// A candidate's own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Own {
    pub(crate) steps: Vec<OwnStep>,
    pub(crate) needs: Vec<VarNeed>,
    /// Needs of what is placed that are no more.
    pub(crate) gone: Vec<Need>,
    pub(crate) late: Vec<Late>,
}

/// Nothing.
pub(crate) static NONE: Own =
    Own { steps: Vec::new(), needs: Vec::new(), gone: Vec::new(), late: Vec::new() };

/// What is placed, and a candidate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) placed: &'a Placed,
    pub(crate) own: &'a Own,
}

/// It overlaps a manual shutdown, from then on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocked;

impl Own {
    /// Of a candidate. It, and what is heated for it, overlaps no manual block.
    pub(crate) fn of(
        problem: &Problem,
        placed: &Placed,
        candidate: Candidate,
        reach: &mut Reach,
    ) -> Result<Self, Blocked> {
        let mut own = Self::default();
        let item = &problem.items[candidate.item];
        let Candidate { start, end, .. } = candidate;
        if start == end {
            return Ok(own);
        }
        own.adds(problem, (start, end), item.draw, Who::Item(candidate.item), reach)?;
        for &zone in &item.zones {
            let model = &problem.zones[zone];
            let use_of_it = (candidate.item, start, end);
            let changed = placed.zones[zone].with(problem, model, use_of_it, reach);
            for old in changed.gone {
                own.takes(problem, (old.from, old.to), model.draw, Who::Item(old.item));
            }
            for new in changed.new {
                let who = Who::Item(new.item);
                own.adds(problem, (new.from, new.to), model.draw, who, reach)?;
                if new.late > 0 {
                    own.late.push(Late { at: new.to, who, by: new.late });
                }
            }
        }
        own.sort(reach);
        Ok(own)
    }

    /// Before which nothing differs from what is placed.
    pub(crate) fn first(&self) -> Option<i64> {
        let gone = self.gone.iter().map(|need| need.from);
        self.needs.iter().map(|need| need.from.at).chain(gone).min()
    }

    fn adds(
        &mut self,
        problem: &Problem,
        (from, to): (Var, Var),
        draw: Draw,
        who: Who,
        reach: &mut Reach,
    ) -> Result<(), Blocked> {
        for block in &problem.blocks {
            if reach.lt(from, Var::fixed(block.to)) && reach.lt(Var::fixed(block.from), to) {
                return Err(Blocked);
            }
        }
        if reach.lt(from, to) {
            let back = Draw { marginal: -draw.marginal, peak: -draw.peak };
            self.steps.push(OwnStep { at: from, draw });
            self.steps.push(OwnStep { at: to, draw: back });
            self.needs.push(VarNeed { from, to, who });
        }
        Ok(())
    }

    fn takes(&mut self, problem: &Problem, (from, to): (i64, i64), draw: Draw, who: Who) {
        let back = Draw { marginal: -draw.marginal, peak: -draw.peak };
        self.steps.push(OwnStep { at: Var::fixed(from), draw: back });
        self.steps.push(OwnStep { at: Var::fixed(to), draw });
        self.gone.extend(super::placed::needs(problem, from, to, who));
    }

    /// In the order in which things happen where it is shifted a little.
    fn sort(&mut self, reach: &mut Reach) {
        self.steps.sort_by_key(|step| step.at.order());
        self.needs.sort_by_key(|need| need.from.order());
        for pair in self.steps.windows(2) {
            let _ = reach.le(pair[0].at, pair[1].at);
        }
        for pair in self.needs.windows(2) {
            let _ = reach.le(pair[0].from, pair[1].from);
        }
    }
}
