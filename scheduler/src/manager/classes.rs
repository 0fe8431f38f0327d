//! Who waits, by class: tasks that need the same wait for the same, so only
//! the most important one of them that is due needs to be looked at.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::manager::demand::Demand;
use crate::manager::point::{Clock, Micros, Point, Present};
use crate::manager::rank::Rank;
use crate::manager::slab::Slab;
use crate::manager::tree::{Item, Looks, Tree};

/// A class, by its index.
pub(crate) type ClassId = u32;

/// An occurrence that is due, and the most important one of its class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Head {
    pub(crate) rank: Rank,
    pub(crate) class: ClassId,
    pub(crate) task: u32,
}

#[derive(Clone, Debug)]
struct Class {
    demand: Arc<Demand>,
    /// One tree for each clock.
    trees: [Tree; 2],
    head: Option<(Rank, u32)>,
    /// When the next one is due, by each clock.
    wakes: [Option<Micros>; 2],
    users: u32,
}

/// All occurrences that have not been asked for at the agents, due or not.
#[derive(Clone, Debug, Default)]
pub(crate) struct Classes {
    /// How many blocks of trees were looked at.
    looks: Looks,
    classes: Slab<Class>,
    by_demand: BTreeMap<Arc<Demand>, ClassId>,
    heads: BTreeSet<Head>,
    wakes: [BTreeSet<(Micros, ClassId)>; 2],
    seen: Present,
}

const CLOCKS: [Clock; 2] = [Clock::Elapsed, Clock::Wall];

const fn side(clock: Clock) -> usize {
    match clock {
        Clock::Elapsed => 0,
        Clock::Wall => 1,
    }
}

impl Classes {
    /// The class of this demand; each user leaves it some day.
    pub(crate) fn join(&mut self, demand: Demand) -> ClassId {
        if let Some(id) = self.by_demand.get(&demand).copied() {
            if let Some(class) = self.class_mut(id) {
                class.users = class.users.saturating_add(1);
            }
            return id;
        }
        let demand = Arc::new(demand);
        let trees = Default::default();
        let class = Class { demand: demand.clone(), trees, head: None, wakes: [None; 2], users: 1 };
        let id = self.classes.insert(class);
        self.by_demand.insert(demand, id);
        id
    }

    pub(crate) fn leave(&mut self, id: ClassId) {
        let Some(class) = self.class_mut(id) else { return };
        class.users = class.users.saturating_sub(1);
        if class.users == 0 {
            let demand = class.demand.clone();
            self.by_demand.remove(&demand);
            self.classes.remove(id);
        }
    }

    pub(crate) fn demand(&self, id: ClassId) -> Arc<Demand> {
        self.class(id).map(|class| class.demand.clone()).unwrap_or_default()
    }

    /// An occurrence waits from now on, for its time or for what it needs.
    pub(crate) fn insert(&mut self, id: ClassId, due: Point, rank: Rank, task: u32) {
        let mut looks = self.looks;
        if let Some(tree) = self.tree(id, due.clock) {
            tree.insert(Item { at: due.at, rank, task }, &mut looks);
        }
        self.looks = looks;
        self.refresh(id);
    }

    pub(crate) fn remove(&mut self, id: ClassId, due: Point, rank: Rank, task: u32) {
        let mut looks = self.looks;
        if let Some(tree) = self.tree(id, due.clock) {
            tree.remove(&Item { at: due.at, rank, task }, &mut looks);
        }
        self.looks = looks;
        self.refresh(id);
    }

    /// Time goes on: classes of which something became due are looked at.
    pub(crate) fn advance(&mut self, now: Present) {
        let back = now.wall < self.seen.wall;
        self.seen = now;
        if back {
            let every = 0..self.classes.places();
            every.for_each(|id| self.refresh(id));
        }
        for clock in CLOCKS {
            while let Some(id) = self.ripe(clock) {
                self.refresh(id);
            }
        }
    }

    fn ripe(&self, clock: Clock) -> Option<ClassId> {
        let (at, id) = *self.wakes.get(side(clock))?.first()?;
        (at <= self.seen.by(clock)).then_some(id)
    }

    /// Looks again for the head of a class and for the time that another one
    /// is due.
    fn refresh(&mut self, id: ClassId) {
        let (seen, mut looks) = (self.seen, self.looks);
        let Some(class) = self.class(id) else { return };
        let [elapsed, wall] = &class.trees;
        let heads =
            [elapsed.best_by(seen.elapsed, &mut looks), wall.best_by(seen.wall, &mut looks)];
        let head = heads.into_iter().flatten().min();
        let wakes =
            [elapsed.next_after(seen.elapsed, &mut looks), wall.next_after(seen.wall, &mut looks)];
        self.looks = looks;
        self.set_head(id, head);
        for (index, at) in wakes.into_iter().enumerate() {
            self.set_wake(id, index, at);
        }
    }

    fn set_head(&mut self, id: ClassId, head: Option<(Rank, u32)>) {
        let Some(class) = self.class_mut(id) else { return };
        let before = core::mem::replace(&mut class.head, head);
        if before == head {
            return;
        }
        if let Some((rank, task)) = before {
            self.heads.remove(&Head { rank, class: id, task });
        }
        if let Some((rank, task)) = head {
            self.heads.insert(Head { rank, class: id, task });
        }
    }

    fn set_wake(&mut self, id: ClassId, index: usize, at: Option<Micros>) {
        let Some(place) = self.class_mut(id).and_then(|class| class.wakes.get_mut(index)) else {
            return;
        };
        let before = core::mem::replace(place, at);
        if before == at {
            return;
        }
        let Some(wakes) = self.wakes.get_mut(index) else { return };
        if let Some(before) = before {
            wakes.remove(&(before, id));
        }
        if let Some(at) = at {
            wakes.insert((at, id));
        }
    }

    /// The most important head after this one.
    pub(crate) fn head_after(&self, head: Option<Head>) -> Option<Head> {
        use core::ops::Bound::{Excluded, Unbounded};
        let from = head.map_or(Unbounded, Excluded);
        self.heads.range((from, Unbounded)).next().copied()
    }

    /// The most important one of a class that is due.
    pub(crate) fn head_of(&self, id: ClassId) -> Option<u32> {
        self.class(id)?.head.map(|(_, task)| task)
    }

    /// How many blocks of trees were looked at.
    pub(crate) const fn looks(&self) -> Looks {
        self.looks
    }

    /// When something becomes due by this clock.
    pub(crate) fn next_due(&self, clock: Clock) -> Option<Micros> {
        self.wakes.get(side(clock))?.first().map(|(at, _)| *at)
    }

    /// Who is due at the next instant of this clock, the most important of each
    /// class first, but not more than so many. Of a class that excludes itself
    /// only the most important can start.
    pub(crate) fn next_group(&self, clock: Clock, most: usize) -> Vec<u32> {
        let Some(at) = self.next_due(clock) else { return Vec::new() };
        let mut group = Vec::new();
        let wakes = self.wakes.get(side(clock)).into_iter().flatten();
        for (_, id) in wakes.take_while(|(due, _)| *due == at) {
            let Some(class) = self.class(*id) else { continue };
            let excludes_itself = class.demand.categories != 0 || class.demand.gates != 0;
            let most = if excludes_itself { group.len().saturating_add(1) } else { most };
            let Some(tree) = class.trees.get(side(clock)) else { continue };
            tree.due_at(at, most, &mut group);
        }
        group.truncate(most);
        group
    }

    fn tree(&mut self, id: ClassId, clock: Clock) -> Option<&mut Tree> {
        self.class_mut(id)?.trees.get_mut(side(clock))
    }

    fn class(&self, id: ClassId) -> Option<&Class> {
        self.classes.get(id)
    }

    fn class_mut(&mut self, id: ClassId) -> Option<&mut Class> {
        self.classes.get_mut(id)
    }
}
