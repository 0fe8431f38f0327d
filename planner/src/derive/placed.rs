//! What is placed, and what follows from it in no way that depends on charge:
//! loads, heating, and when the computer must be up. Kept sorted; a candidate
//! is looked at as a small change of it, and the same from nothing is equal.

use crate::problem::{Draw, Known, Problem};

use super::heat::{Heat, Use, ZoneLine};

/// A change of what is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Step {
    pub(crate) at: i64,
    pub(crate) marginal: i64,
    pub(crate) peak: i64,
}

/// Who needs the computer. In the order in which they count at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Who {
    /// It comes up at the end of a manual block.
    AfterBlock,
    /// It is up, or wakes up, already.
    Present,
    /// A communication window.
    Window,
    /// An activity, or heating for it.
    Item(usize),
    /// It must be up when a manual block begins.
    Block,
}

/// The computer must be up: half-open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Need {
    pub(crate) from: i64,
    pub(crate) who: Who,
    pub(crate) to: i64,
}

/// An activity at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Placement {
    pub(crate) item: usize,
    pub(crate) start: i64,
    pub(crate) end: i64,
}

/// Everything that is placed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Placed {
    pub(crate) steps: Vec<Step>,
    pub(crate) needs: Vec<Need>,
    pub(crate) zones: Vec<ZoneLine>,
}

impl Placed {
    /// What is so whatever is planned: windows, manual blocks, what runs.
    pub(crate) fn first(problem: &Problem) -> Self {
        let zones = problem.zones.iter().map(ZoneLine::new).collect();
        let mut placed = Self { steps: Vec::new(), needs: Vec::new(), zones };
        placed.windows(problem);
        placed.blocks(problem);
        placed.present(problem);
        for (item, it) in problem.items.iter().enumerate() {
            match it.fate {
                Known::Running { start, end, paused } => {
                    let draw =
                        Draw { marginal: if paused { 0 } else { it.draw.marginal }, ..it.draw };
                    placed.put(problem, Placement { item, start, end }, draw);
                }
                Known::Ended { used: Some((start, end)), .. } => {
                    placed.uses(problem, Placement { item, start, end });
                }
                _ => {}
            }
        }
        placed
    }

    /// The same, and these: from nothing.
    #[cfg(test)]
    pub(crate) fn full(problem: &Problem, slots: &[Placement]) -> Self {
        let mut placed = Self::first(problem);
        for &slot in slots {
            placed.insert(problem, slot);
        }
        placed
    }

    pub(crate) fn insert(&mut self, problem: &Problem, slot: Placement) {
        self.put(problem, slot, problem.items[slot.item].draw);
    }

    pub(crate) fn remove(&mut self, problem: &Problem, slot: Placement) {
        let draw = problem.items[slot.item].draw;
        self.draw(problem, slot.start, slot.end, draw, -1);
        for need in needs(problem, slot.start, slot.end, Who::Item(slot.item)) {
            take(&mut self.needs, need);
        }
        for &zone in &problem.items[slot.item].zones {
            let old = self.zones[zone].remove(problem, &problem.zones[zone], used(slot));
            self.heats(problem, zone, &old);
        }
    }

    fn put(&mut self, problem: &Problem, slot: Placement, draw: Draw) {
        self.draw(problem, slot.start, slot.end, draw, 1);
        self.need(problem, slot.start, slot.end, Who::Item(slot.item));
        self.uses(problem, slot);
    }

    fn uses(&mut self, problem: &Problem, slot: Placement) {
        for &zone in &problem.items[slot.item].zones {
            let changed = self.zones[zone].insert(problem, &problem.zones[zone], used(slot));
            self.heats(problem, zone, &changed);
        }
    }

    /// Takes heating away (`false`) or adds some.
    fn heats(&mut self, problem: &Problem, zone: usize, changed: &[(Heat, bool)]) {
        for &(heat, added) in changed {
            let sign = if added { 1 } else { -1 };
            self.draw(problem, heat.from, heat.to, problem.zones[zone].draw, sign);
            for need in needs(problem, heat.from, heat.to, Who::Item(heat.item)) {
                if added { add(&mut self.needs, need) } else { take(&mut self.needs, need) }
            }
        }
    }

    fn draw(&mut self, problem: &Problem, from: i64, to: i64, draw: Draw, sign: i64) {
        let (from, to) = (from.max(problem.now), to.min(problem.end));
        if from >= to || draw == Draw::default() {
            return;
        }
        let (marginal, peak) = (draw.marginal, draw.peak);
        let up = Step { at: from, marginal, peak };
        let down = Step { at: to, marginal: -marginal, peak: -peak };
        for step in [up, down] {
            if sign > 0 { add(&mut self.steps, step) } else { take(&mut self.steps, step) }
        }
    }

    fn need(&mut self, problem: &Problem, from: i64, to: i64, who: Who) {
        for need in needs(problem, from, to, who) {
            add(&mut self.needs, need);
        }
    }

    fn windows(&mut self, problem: &Problem) {
        for window in &problem.state.windows {
            let (from, to) = (window.start.get(), window.end.get());
            let load = crate::parameters::Load { marginal: window.marginal, peak: window.peak };
            self.draw(problem, from, to, load.into(), 1);
            if window.awake {
                self.need(problem, from, to, Who::Window);
            }
        }
    }

    /// The computer's own loads in them included.
    fn blocks(&mut self, problem: &Problem) {
        let computer = &problem.computer;
        for block in &problem.blocks {
            self.draw(problem, block.from, block.shutdown_until, computer.shutdown, 1);
            self.draw(problem, block.wakeup_from, block.to, computer.wakeup, 1);
            if block.from > problem.now {
                add(&mut self.needs, Need { from: block.from, who: Who::Block, to: block.from });
            }
            if block.to < problem.end {
                add(&mut self.needs, Need { from: block.to, who: Who::AfterBlock, to: block.to });
            }
        }
        for item in &problem.items {
            if let Known::Block(Some((from, to))) = item.fate {
                self.draw(problem, from, to, item.draw, 1);
            }
        }
    }

    fn present(&mut self, problem: &Problem) {
        use crate::state::Mode;
        let computer = &problem.computer;
        let from = match computer.mode {
            _ if problem.present_block().is_some() => return,
            Mode::Awake => problem.now,
            Mode::WakingUp => problem.now.max(computer.since + computer.wakeup_time),
            Mode::Asleep | Mode::ShuttingDown => return,
        };
        add(&mut self.needs, Need { from, who: Who::Present, to: from });
    }
}

const fn used(slot: Placement) -> Use {
    Use { start: slot.start, item: slot.item, end: slot.end }
}

/// When the computer must be up for it: from now on, until the end, and not in
/// manual blocks, which are refused elsewhere where that can be.
pub(crate) fn needs(problem: &Problem, from: i64, to: i64, who: Who) -> Vec<Need> {
    let (mut from, to) = (from.max(problem.now), to.min(problem.end));
    let mut needs = Vec::new();
    for block in &problem.blocks {
        if block.from < to && from < block.to {
            if from < block.from {
                needs.push(Need { from, who, to: block.from });
            }
            from = block.to;
        }
    }
    if from < to {
        needs.push(Need { from, who, to });
    }
    needs
}

fn add<T: Ord>(sorted: &mut Vec<T>, new: T) {
    let at = sorted.partition_point(|old| *old < new);
    sorted.insert(at, new);
}

fn take<T: Ord>(sorted: &mut Vec<T>, old: T) {
    if let Ok(at) = sorted.binary_search(&old) {
        sorted.remove(at);
    }
}
