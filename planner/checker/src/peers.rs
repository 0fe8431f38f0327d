//! Planners to compare a planner with: one that is naive, and one that is never
//! beaten because it tries everything.

use std::collections::BTreeSet;

use faregate_planner::timed::TimedPlan;
use faregate_planner::{Parameters, Plan, State};

use crate::brute::Pass;
use crate::candidates::{is_valid, may_start, order, ranges};
use crate::scene::{Placed, Scene};
use crate::valid::chosen;
use crate::world::World;

/// What somebody would write first: the activities in the plan's order, whatever
/// their priorities; each at its earliest start on a grid of `grid` milliseconds
/// at which it fits; nobody gets a second chance, nothing is expanded.
#[must_use]
pub fn naive(plan: &Plan, parameters: &Parameters, state: &State, grid: i64) -> TimedPlan {
    let scene = Scene::new(plan, parameters, state, None);
    let mut pass = Pass::new(&scene);
    let mut order = order(&scene);
    order.sort_unstable();
    for index in order {
        let fits = starts(&scene, &pass.world, index, grid).into_iter();
        let mut fits = fits.filter(|slot| is_valid(&scene, &pass.world, slot));
        if let Some(slot) = fits.next() {
            pass.place(slot);
        }
    }
    pass.answer()
}

/// The largest sum of worths that any choice of starts, placed in any order
/// within the rules, comes to.
///
/// # Timing
///
/// Hopeless but for a handful of activities with few starts: everything is
/// tried, but for what cannot be worth more than the best so far.
#[must_use]
pub fn optimum(plan: &Plan, parameters: &Parameters, state: &State) -> u64 {
    let scene = Scene::new(plan, parameters, state, None);
    let mut search = Search { scene: &scene, best: 0, seen: BTreeSet::new() };
    let order = order(&scene);
    search.go(&World::base(&scene), &order, 0);
    search.best
}

struct Search<'s, 'a> {
    scene: &'s Scene<'a>,
    best: u64,
    /// Sets of slots from which everything was tried.
    seen: BTreeSet<Vec<(usize, i64)>>,
}

impl<'a> Search<'_, 'a> {
    fn go(&mut self, world: &World<'a>, rest: &[usize], worth: u64) {
        self.best = self.best.max(worth);
        let mut slots: Vec<_> = world.placed.iter().map(|p| (p.index, p.start)).collect();
        slots.sort_unstable();
        let hope: u64 = rest.iter().map(|index| self.worth(*index)).sum();
        if worth + hope <= self.best || !self.seen.insert(slots) {
            return;
        }
        for index in rest {
            let others: Vec<usize> = rest.iter().copied().filter(|i| i != index).collect();
            for slot in starts(self.scene, world, *index, 1) {
                if is_valid(self.scene, world, &slot) {
                    let with = world.with(self.scene, slot);
                    self.go(&with, &others, worth + self.worth(*index));
                }
            }
        }
    }

    fn worth(&self, index: usize) -> u64 {
        self.scene.activity(index).worth()
    }
}

/// Slots that ranges, dependencies and groups leave, in order: those whose start
/// is a multiple of `grid`.
fn starts(scene: &Scene<'_>, world: &World<'_>, index: usize, grid: i64) -> Vec<Placed> {
    let Some(from) = may_start(scene, world, index) else { return Vec::new() };
    let length = scene.activity(index).placed().get();
    let step = usize::try_from(grid).unwrap_or(1).max(1);
    let ranges = ranges(scene, index, from).into_iter();
    let first = |first: i64| (first + grid - 1).div_euclid(grid) * grid;
    let mut all: Vec<i64> =
        ranges.flat_map(|(from, to)| (first(from)..=to).step_by(step)).collect();
    all.sort_unstable();
    all.dedup();
    all.into_iter().map(|start| chosen(index, start, start + length)).collect()
}
