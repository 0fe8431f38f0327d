//! Which sequence engines an activity has: categories of the mission.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::task::TaskId;

use super::Misfit;
use crate::timed::Slot;

/// The name of the category of an engine, from 0.
pub(super) fn name(engine: usize) -> String {
    format!("engine {}", engine + 1)
}

/// The category of an engine.
pub(super) fn category(mission: &Mission, engine: usize) -> Option<Categories> {
    let bit = mission.categories.get(&name(engine))?;
    1_u128.checked_shl(u32::from(*bit)).map(Categories::from_mask)
}

/// The categories of all engines.
pub(super) fn all(mission: &Mission, engines: u32) -> Result<Vec<Categories>, Vec<Misfit>> {
    let engines = 0..usize::try_from(engines).unwrap_or(usize::MAX);
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    // There are no more bits than that, so the first that is missing is one.
    for engine in engines.take(129) {
        match category(mission, engine) {
            Some(category) => found.push(category),
            None => missing.push(Misfit::Engine(engine)),
        }
    }
    if missing.is_empty() { Ok(found) } else { Err(missing) }
}

/// Engines that are had: by whom, and when.
#[derive(Clone, Debug)]
pub(super) struct Engines<'a> {
    all: &'a [Categories],
    had: Vec<(Slot, Categories)>,
    pub(super) of: BTreeMap<TaskId, Categories>,
}

/// Somebody who needs engines for a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wish {
    pub(super) id: TaskId,
    pub(super) slot: Slot,
    pub(super) count: usize,
}

impl<'a> Engines<'a> {
    /// Gives everybody engines: those that are held already stay with whom they
    /// are as far as that is possible.
    ///
    /// What runs keeps its own whatever happens. Beside that, in order of start
    /// the first engines that are free are always enough, where the sums are: it
    /// is only what was given before and lies later that can leave no single
    /// engine free, and then it is given anew.
    pub(super) fn assign(
        all: &'a [Categories],
        wishes: &[Wish],
        runs: &BTreeMap<TaskId, Categories>,
        given: &BTreeMap<TaskId, Categories>,
    ) -> Self {
        let mut wishes: Vec<_> = wishes.iter().filter(|wish| wish.count > 0).copied().collect();
        wishes.sort_by_key(|wish| (wish.slot.start, wish.id));
        Self::with(all, &wishes, runs, given)
            .or_else(|| Self::with(all, &wishes, runs, &BTreeMap::new()))
            .unwrap_or_else(|| Self::crowded(all, &wishes, runs))
    }

    fn with(
        all: &'a [Categories],
        wishes: &[Wish],
        runs: &BTreeMap<TaskId, Categories>,
        given: &BTreeMap<TaskId, Categories>,
    ) -> Option<Self> {
        let mut engines = Self { all, had: Vec::new(), of: BTreeMap::new() };
        engines.keep(wishes, runs, false);
        engines.keep(wishes, given, true);
        for wish in wishes {
            if engines.of.contains_key(&wish.id) {
                continue;
            }
            let free = engines.free(wish.slot);
            if free.len() < wish.count {
                return None;
            }
            engines.give(*wish, free);
        }
        Some(engines)
    }

    /// Where something runs that the plan did not foresee, somebody waits.
    fn crowded(
        all: &'a [Categories],
        wishes: &[Wish],
        runs: &BTreeMap<TaskId, Categories>,
    ) -> Self {
        let mut engines = Self { all, had: Vec::new(), of: BTreeMap::new() };
        engines.keep(wishes, runs, false);
        for wish in wishes.iter().filter(|wish| !runs.contains_key(&wish.id)) {
            let mut free = engines.free(wish.slot);
            let others = all.iter().filter(|one| !free.contains(one)).copied().collect::<Vec<_>>();
            free.extend(others);
            engines.give(*wish, free);
        }
        engines
    }

    /// Those that have engines keep them; what was only given is not kept where
    /// two have moved together since.
    fn keep(&mut self, wishes: &[Wish], has: &BTreeMap<TaskId, Categories>, only_free: bool) {
        for wish in wishes {
            let Some(has) = has.get(&wish.id).filter(|_| !self.of.contains_key(&wish.id)) else {
                continue;
            };
            let free = self.free(wish.slot).into_iter().fold(Categories::NONE, Categories::union);
            if !only_free || has.shared(free) == *has {
                self.had.push((wish.slot, *has));
                self.of.insert(wish.id, *has);
            }
        }
    }

    fn free(&self, slot: Slot) -> Vec<Categories> {
        let overlaps = |other: &Slot| other.start < slot.end && slot.start < other.end;
        let had = self.had.iter().filter(|(other, _)| overlaps(other));
        let taken = had.fold(Categories::NONE, |sum, (_, has)| sum.union(*has));
        self.all.iter().filter(|engine| !engine.overlaps(taken)).copied().collect()
    }

    fn give(&mut self, wish: Wish, free: Vec<Categories>) {
        let has = free.into_iter().take(wish.count).fold(Categories::NONE, Categories::union);
        self.had.push((wish.slot, has));
        self.of.insert(wish.id, has);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Time;

    const fn engine(bit: u32) -> Categories {
        Categories::from_mask(1 << bit)
    }

    fn wish(id: u32, start: i64, end: i64, count: usize) -> Option<Wish> {
        let slot = Slot { start: Time::new(start), end: Time::new(end), range: 0 };
        Some(Wish { id: TaskId::new(id)?, slot, count })
    }

    fn nobody_shares(wishes: &[Wish], engines: &Engines<'_>) -> bool {
        wishes.iter().enumerate().all(|(at, one)| {
            wishes.iter().skip(at + 1).all(|other| {
                let meet = one.slot.start < other.slot.end && other.slot.start < one.slot.end;
                !meet || !engines.of[&one.id].overlaps(engines.of[&other.id])
            })
        })
    }

    #[test]
    fn the_engines_that_the_planner_counted_are_enough_for_each_its_own() {
        let all = [engine(5), engine(9), engine(7)];
        let wishes: Vec<_> =
            [wish(1, 0, 10, 2), wish(2, 0, 30, 1), wish(3, 10, 20, 1), wish(4, 15, 40, 1)]
                .into_iter()
                .flatten()
                .collect();
        let none = BTreeMap::new();
        let engines = Engines::assign(&all, &wishes, &none, &none);
        assert_eq!(engines.of.len(), 4);
        assert!(nobody_shares(&wishes, &engines));
    }

    #[test]
    fn what_was_given_before_is_given_anew_where_no_single_engine_is_left() {
        let all = [engine(0), engine(1)];
        let wishes: Vec<_> = [wish(1, 0, 20, 1), wish(2, 5, 10, 1), wish(3, 10, 20, 1)]
            .into_iter()
            .flatten()
            .collect();
        let none = BTreeMap::new();
        // Each engine has been given to somebody in the time of the first.
        let given = wishes[1..].iter().map(|wish| wish.id).zip(all).collect();
        let engines = Engines::assign(&all, &wishes, &none, &given);
        assert!(nobody_shares(&wishes, &engines));
        // Two that were apart before cannot keep the same engine.
        let given = wishes[..2].iter().map(|wish| (wish.id, engine(1))).collect();
        let engines = Engines::assign(&all, &wishes, &none, &given);
        assert!(nobody_shares(&wishes, &engines));
        // And what runs stays, even then.
        let runs = BTreeMap::from([(wishes[1].id, engine(0))]);
        let engines = Engines::assign(&all, &wishes, &runs, &given);
        assert_eq!(engines.of[&wishes[1].id], engine(0));
        assert!(nobody_shares(&wishes, &engines));
    }
}
