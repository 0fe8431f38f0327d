//! Who runs: one walk down the order of importance, from scratch.
//!
//! Each occurrence gets all that it needs or nothing. So the set that runs is
//! what brute force would find, and a victim is never taken in vain: who is
//! granted fits together with everybody more important who is granted.

use std::sync::Arc;

use crate::manager::classes::{ClassId, Head};
use crate::manager::demand::Demand;
use crate::manager::entry::{Asked, Entry, Stage, Then};
use crate::manager::ledger::{Ledger, Part, Short};
use crate::manager::limits::SLOTS;
use crate::manager::rank::Rank;
use crate::manager::step::Step;
use crate::manager::{HeldBy, WaitsFor};
use crate::task::{Preemption, TaskId};

/// What the walk has given away, and to whom.
#[derive(Debug)]
struct Walk {
    ledger: Ledger,
    /// Who was given what.
    holders: Vec<(TaskId, Arc<Demand>)>,
    /// Who waits in vain, and is more important than who comes after.
    waiting: Vec<(TaskId, Arc<Demand>)>,
    slots: usize,
    requests: usize,
    /// Who waits at the agents for something outside: its class, and why.
    blocked: Vec<(ClassId, String)>,
    /// Memory and storage of those who have not started.
    starting: (u64, u64),
}

/// Who is looked at next.
enum Next {
    Live(u32),
    Head(Head),
}

impl Step<'_> {
    /// Marks who of the live ones runs; takes those who join them out of their
    /// classes.
    pub(crate) fn walk(&mut self) {
        let mut walk = self.start_of_walk();
        let live = self.live_candidates();
        let mut live = live.into_iter().peekable();
        let mut cursor: Option<Head> = None;
        let mut joins = !self.manager.shutting_down;
        loop {
            let head = if joins { self.manager.classes.head_after(cursor) } else { None };
            let next = match (live.peek(), head) {
                (Some((rank, index)), Some(head)) if *rank < head.rank => Next::Live(*index),
                (_, Some(head)) => Next::Head(head),
                (Some((_, index)), None) => Next::Live(*index),
                (None, None) => break,
            };
            self.manager.looks = self.manager.looks.wrapping_add(1);
            match next {
                Next::Live(index) => {
                    live.next();
                    self.look_at_live(&mut walk, index);
                }
                Next::Head(head) => {
                    cursor = Some(head);
                    joins = self.look_at_head(&mut walk, head);
                }
            }
        }
    }

    /// What nobody can have: gaps, bodies that cannot be stopped, memory of
    /// bodies that stand still.
    fn start_of_walk(&mut self) -> Walk {
        let mut walk = Walk {
            ledger: self.manager.ledger(),
            holders: Vec::new(),
            waiting: Vec::new(),
            slots: 0,
            requests: 0,
            blocked: Vec::new(),
            starting: (0, 0),
        };
        for gap in &self.manager.gaps {
            walk.ledger.categories |= gap.categories;
        }
        for index in self.manager.live.clone() {
            let Some(entry) = self.entry(index) else { continue };
            let demand = self.manager.classes.demand(entry.class);
            let id = entry.task.id;
            if self.is_unmovable(entry) {
                walk.ledger.take(&demand, Part::All);
                walk.holders.push((id, demand));
                walk.slots += 1;
                self.choose(index, Ok(()));
            } else if entry.keeps_memory() {
                walk.ledger.reserve(&demand);
            }
        }
        walk
    }

    /// No task takes what these have.
    fn is_unmovable(&self, entry: &Entry) -> bool {
        match entry.run.stage {
            Stage::Runaway(_) => true,
            Stage::Running => {
                entry.task.preemption == Preemption::Wait && self.objection(entry).is_none()
            }
            _ => false,
        }
    }

    /// The live ones that want to run, most important first.
    fn live_candidates(&self) -> Vec<(Rank, u32)> {
        let live = self.manager.live.iter();
        let entries = live.filter_map(|index| Some((*index, self.entry(*index)?)));
        let mut candidates: Vec<_> = entries
            .filter(|(_, entry)| entry.is_candidate() && !self.is_unmovable(entry))
            .map(|(index, entry)| (entry.rank(), index))
            .collect();
        candidates.sort_unstable();
        candidates
    }

    fn look_at_live(&mut self, walk: &mut Walk, index: u32) {
        let Some(entry) = self.entry(index) else { return };
        let demand = self.manager.classes.demand(entry.class);
        let part = if entry.keeps_memory() { Part::Running } else { Part::All };
        let idle = entry.run.stage == Stage::Idle;
        let granted = entry.run.asked == Asked::Granted;
        let id = entry.task.id;
        let objection = self.objection(entry);
        if let (Asked::Blocked(why), None) = (&entry.run.asked, &objection) {
            walk.leave_to_the_agents(id, demand);
            walk.blocked.push((entry.class, why.clone()));
            let why = WaitsFor::Tickets(why.clone());
            return self.choose(index, Err(why));
        }
        let held_back = objection.is_some();
        let obstacle = objection
            .or_else(|| if idle { self.cannot_start(walk, &demand) } else { None })
            .or_else(|| (walk.slots >= SLOTS).then_some(WaitsFor::Slot))
            .or_else(|| self.does_not_fit(walk, &demand, part));
        if obstacle.is_none() {
            walk.give(id, &demand, part, idle);
            walk.requests += usize::from(idle && !granted);
        } else if !held_back {
            walk.waiting.push((id, demand));
        }
        self.choose(index, obstacle.map_or(Ok(()), Err));
    }

    fn choose(&mut self, index: u32, chosen: Result<(), WaitsFor>) {
        if let Some(entry) = self.entry_mut(index) {
            entry.run.chosen = chosen;
        }
    }

    /// Lets the head of a class join, and looks at the next one of the class
    /// later; or the class waits. Answers whether anybody else could join.
    fn look_at_head(&mut self, walk: &mut Walk, head: Head) -> bool {
        let Some(entry) = self.entry(head.task) else { return true };
        let id = entry.task.id;
        let demand = self.manager.classes.demand(head.class);
        if let Some(why) = self.is_out_of_order(walk, head.class) {
            self.tell_waits(head.task, WaitsFor::Tickets(why));
            return true;
        }
        let is_full = walk.slots >= SLOTS || walk.requests >= self.manager.mission.waiting_requests;
        if is_full {
            self.tell_waits(head.task, WaitsFor::Slot);
            return false;
        }
        if let Some(objection) = self.objection(entry) {
            self.tell_waits(head.task, objection);
            return true;
        }
        let obstacle = self
            .cannot_start(walk, &demand)
            .or_else(|| self.does_not_fit(walk, &demand, Part::All));
        if let Some(obstacle) = obstacle {
            walk.waiting.push((id, demand));
            self.tell_waits(head.task, obstacle);
            return true;
        }
        walk.give(id, &demand, Part::All, true);
        walk.requests += 1;
        self.enlist(head.task);
        true
    }

    /// What others of this class wait for at the agents already. So many may wait
    /// there that somebody else could not: then one of a class is enough.
    fn is_out_of_order(&self, walk: &Walk, class: ClassId) -> Option<String> {
        if walk.blocked.len() < self.manager.mission.waiting_requests / 2 {
            return None;
        }
        let alike = walk.blocked.iter().find(|(other, _)| *other == class);
        alike.map(|(_, why)| why.clone())
    }

    /// What keeps an occurrence from running whoever else runs.
    pub(crate) fn objection(&self, entry: &Entry) -> Option<WaitsFor> {
        if entry.held {
            return Some(WaitsFor::Held);
        }
        let demand = self.manager.classes.demand(entry.class);
        let mode = self.manager.modes.against(entry.task.priority, &demand);
        // Who stands still, for whatever reason, would use what is short.
        let is_kept = entry.run.short || entry.run.stage == Stage::Paused;
        mode.or_else(|| is_kept.then(|| self.manager.shortage()).flatten())
    }

    /// What keeps an occurrence without a body from getting one.
    fn cannot_start(&self, walk: &Walk, demand: &Demand) -> Option<WaitsFor> {
        let measured = self.manager.keeps_from_starting(demand, walk.starting);
        measured.or_else(|| if demand.waits { walk.starves(demand) } else { None })
    }

    fn does_not_fit(&self, walk: &Walk, demand: &Demand, part: Part) -> Option<WaitsFor> {
        let short = walk.ledger.short(demand, part, &self.manager.installed)?;
        Some(match short {
            Short::Categories(mask) => WaitsFor::Categories {
                shared: faregate_agents::Categories::from_mask(mask),
                by: self.who_has(walk, |demand| demand.categories & mask != 0, mask),
            },
            Short::Gates(bits) => WaitsFor::Gate {
                gate: self.manager.gate_name(bits),
                by: self.who_has(walk, |demand| demand.gates & bits != 0, 0),
            },
            Short::Draw(milliwatts) => {
                WaitsFor::Draw { short_by: faregate_tickets::amount::Milliwatts::new(milliwatts) }
            }
            Short::Memory(short_by) => WaitsFor::Memory { short_by },
            Short::Storage(short_by) => WaitsFor::Storage { short_by },
        })
    }

    fn who_has(&self, walk: &Walk, has: impl Fn(&Demand) -> bool, categories: u128) -> HeldBy {
        if let Some(gap) = self.manager.gaps.iter().find(|gap| gap.categories & categories != 0) {
            return HeldBy::GapOf(gap.task);
        }
        let holder = walk.holders.iter().find(|(_, demand)| has(demand));
        holder.map_or(HeldBy::Unknown, |(id, _)| HeldBy::Task(*id))
    }
}

impl Walk {
    fn give(&mut self, id: TaskId, demand: &Arc<Demand>, part: Part, starts: bool) {
        self.ledger.take(demand, part);
        self.holders.push((id, demand.clone()));
        self.slots += 1;
        if starts {
            self.starting.0 = self.starting.0.saturating_add(demand.memory);
            self.starting.1 = self.starting.1.saturating_add(demand.storage);
        }
    }

    /// It waits at the agents for something outside: others need not wait for
    /// it meanwhile, but must not starve it.
    fn leave_to_the_agents(&mut self, id: TaskId, demand: Arc<Demand>) {
        self.waiting.push((id, demand));
        self.slots += 1;
        self.requests += 1;
    }

    /// A task that cannot be pre-empted would keep somebody more important,
    /// who waits for more than this, waiting for good.
    fn starves(&self, demand: &Demand) -> Option<WaitsFor> {
        let waiting = self.waiting.iter().find(|(_, other)| other.shares_with(demand));
        waiting.map(|(id, _)| WaitsFor::MoreImportant(*id))
    }
}

impl Entry {
    /// Whether a live occurrence wants to run.
    fn is_candidate(&self) -> bool {
        match &self.run.stage {
            Stage::Idle | Stage::Paused | Stage::Running => true,
            Stage::Stopping { then, .. } => *then == Then::Again,
            Stage::Runaway(_) => false,
        }
    }

    /// Whether what it reserved stays reserved when it is stopped.
    pub(crate) fn keeps_memory(&self) -> bool {
        use crate::manager::Stop;
        match &self.run.stage {
            Stage::Idle => false,
            Stage::Paused | Stage::Runaway(_) => true,
            Stage::Stopping { how, .. } => *how == Stop::Pause,
            Stage::Running => {
                matches!(self.task.preemption, Preemption::Pause | Preemption::Wait)
            }
        }
    }
}
