//! Who needs the computer next, and when it must be up for that.

use crate::derive::own::VarNeed;
use crate::derive::placed::Who;
use crate::derive::var::Var;
use crate::energy::Watch;

use super::Sweep;

impl<W: Watch> Sweep<'_, '_, W> {
    /// The next need.
    pub(super) fn need(&mut self) -> Option<VarNeed> {
        let frame = self.energy.frame;
        let mut placed = frame.placed.needs.get(self.met.0);
        while let Some(need) = placed
            && frame.own.gone.contains(need)
        {
            self.met.0 += 1;
            placed = frame.placed.needs.get(self.met.0);
        }
        let placed = placed.map(|need| VarNeed {
            from: Var::fixed(need.from),
            to: Var::fixed(need.to),
            who: need.who,
        });
        let own = frame.own.needs.get(self.met.1).copied();
        match (placed, own) {
            (Some(placed), Some(own)) => {
                Some(if self.reach.le(placed.from, own.from) { placed } else { own })
            }
            (placed, own) => placed.or(own),
        }
    }

    /// The next need is met.
    pub(super) fn meet(&mut self, need: VarNeed) {
        let own = self.energy.frame.own.needs.get(self.met.1);
        if own.is_some_and(|own| own.who == need.who && own.from == need.from) {
            self.met.1 += 1;
        } else {
            self.met.0 += 1;
        }
    }

    /// When it is up for a need: earlier, where the phase would otherwise end
    /// before it is long enough.
    fn up_for(&mut self, need: VarNeed) -> Var {
        if need.who == Who::AfterBlock {
            return need.from;
        }
        let block = self.problem.next_block(need.from.at).map(|block| block.from);
        let last = Var::fixed(block.unwrap_or(self.problem.end));
        self.min(need.from, last.later(-self.problem.computer.min_awake))
    }

    pub(super) fn wakeup_for(&mut self, need: VarNeed) -> Var {
        self.up_for(need).later(-self.problem.computer.wakeup_time)
    }
}
