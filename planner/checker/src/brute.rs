//! The one-pass plan by trying every start: the slowest planner there is, for
//! small worlds. What a planner answers must be the same.

use faregate_planner::plan::{ActivityId, Kind};
use faregate_planner::timed::{AwakePhase, Excess, Fate, Preheat, Reason, Row, Slot, TimedPlan};
use faregate_planner::{Parameters, Plan, State};

use crate::candidates::{earliest, excesses, longer, order, range_of, ranges};
use crate::kept::{keep, wanted, worth};
use crate::scene::{Placed, Scene, block, time};
use crate::unavoidable::unavoidable;
use crate::valid::{Broken, Priors, broken, chosen, group_taken, priors};
use crate::world::World;

/// The plan of one pass, a second look and expansion, found by trying every
/// millisecond. With an incumbent, what that becomes, where the pass is worth
/// less than it.
///
/// # Timing
///
/// Hopeless but for small worlds: it derives everything anew for each start of
/// each activity.
#[must_use]
pub fn reference(
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
    incumbent: Option<&TimedPlan>,
) -> TimedPlan {
    let scene = Scene::new(plan, parameters, state, incumbent);
    let order = order(&scene);
    let mut pass = Pass::new(&scene);
    pass.run(&order);
    let Some(incumbent) = incumbent else { return pass.answer() };
    let wanted = wanted(&scene, incumbent, &order);
    let hoped: Vec<Placed> = scene.fixed.iter().chain(&wanted).copied().collect();
    let is_less = |pass: &Pass<'_, '_>, than: &[Placed]| {
        worth(&scene, &pass.world.placed) < worth(&scene, than)
    };
    if is_less(&pass, &hoped) {
        let mut kept = Pass::new(&scene);
        keep(&mut kept, incumbent, &wanted);
        kept.run(&order);
        if is_less(&pass, &kept.world.placed) {
            pass = kept;
        }
    }
    pass.answer()
}

/// A plan in the making.
pub(crate) struct Pass<'s, 'a> {
    pub(crate) scene: &'s Scene<'a>,
    pub(crate) world: World<'a>,
    pub(crate) excess: Vec<Excess>,
}

impl<'s, 'a> Pass<'s, 'a> {
    pub(crate) fn new(scene: &'s Scene<'a>) -> Self {
        Self { world: World::base(scene), scene, excess: Vec::new() }
    }

    /// All that is still to be decided.
    fn run(&mut self, order: &[usize]) {
        loop {
            while self.round(order) {}
            for index in order {
                self.expand(*index, i64::MAX);
            }
            // What was expanded drains more, so that one that was left out may
            // fit.
            if !self.round(order) {
                return;
            }
        }
    }

    /// Tries all that are not in, in order: whether one came in.
    fn round(&mut self, order: &[usize]) -> bool {
        let mut any = false;
        for index in order {
            if self.world.find(*index).is_none()
                && let Some(placed) = earliest(self.scene, &self.world, *index)
            {
                self.place(placed);
                any = true;
            }
        }
        any
    }

    pub(crate) fn place(&mut self, placed: Placed) {
        let with = self.world.with(self.scene, placed);
        if !self.scene.is_optional(placed.index) {
            self.excess.extend(exceeded(self.scene, &self.world, &with, placed.index));
        }
        self.world = with;
    }

    /// As far as everything stays valid, and up to `until` at most: its end then.
    pub(crate) fn expand(&mut self, index: usize, until: i64) -> i64 {
        let end = |world: &World<'_>| world.find(index).map_or(i64::MIN, |placed| placed.end);
        let expands = matches!(self.scene.activity(index).kind, Kind::Expanding { .. });
        let before = self.world.clone();
        while expands
            && end(&self.world) < until
            && let Some(longer) = longer(self.scene, &before, &self.world, index)
        {
            self.world = longer;
        }
        end(&self.world)
    }

    pub(crate) fn answer(self) -> TimedPlan {
        let activities = self.scene.plan.activities.iter().enumerate();
        let rows = activities.map(|(index, a)| Row { id: a.id, fate: self.fate(index) }).collect();
        let phases = self.world.phases.iter();
        let awake = phases.map(|phase| AwakePhase {
            wakeup: time(phase.wakeup),
            up: time(phase.up),
            down: time(phase.down),
            asleep: time(phase.asleep),
        });
        let preheats = self.world.heatings.iter().map(|heating| Preheat {
            zone: heating.zone.to_owned(),
            start: time(heating.start),
            end: time(heating.end),
        });
        let (awake, preheats) = (awake.collect(), preheats.collect());
        let unavoidable = unavoidable(self.scene, &World::base(self.scene));
        TimedPlan { rows, awake, preheats, excess: self.excess, unavoidable }
    }

    fn fate(&self, index: usize) -> Fate {
        let id = self.scene.activity(index).id;
        if let Some(ended) = self.scene.ended(id) {
            return Fate::Ended(ended.outcome);
        }
        let Some(placed) = self.world.find(index) else {
            return Fate::Out(reason(self.scene, &self.world, index));
        };
        let range = range_of(self.scene, placed);
        let slot = Slot { start: time(placed.start), end: time(placed.end), range };
        if self.scene.is_running(id) { Fate::Running(slot) } else { Fate::Scheduled(slot) }
    }
}

/// Why it is left out, as the world stands in the end.
fn reason(scene: &Scene<'_>, world: &World<'_>, index: usize) -> Reason {
    let from = match priors(scene, world, index) {
        Priors::From(from) => from,
        Priors::Ended(prior, outcome) => return Reason::PriorEnded(prior, outcome),
        Priors::Out(prior) => return Reason::PriorOut(prior),
        Priors::Waits(prior) => return Reason::WaitsForOutcome(prior),
    };
    if let Some(member) = group_taken(scene, world, index) {
        return Reason::GroupTaken(member);
    }
    let first = ranges(scene, index, from).into_iter().map(|(first, _)| first).min();
    let manual = block(index, scene.activity(index)).is_some();
    let Some(start) = first.filter(|_| !manual) else { return Reason::NoRangeLeft };
    let slot = chosen(index, start, start + scene.activity(index).placed().get());
    let broken = broken(scene, world, &world.with(scene, slot), &slot);
    broken.map_or(Reason::NoRangeLeft, |broken| Reason::Limit {
        limit: broken.limit,
        at: time(broken.at),
        amount: i64::try_from(broken.amount).unwrap_or(i64::MAX),
        with: broken.with,
    })
}

/// What a mandatory activity exceeds, as it is listed.
pub(crate) fn exceeded(
    scene: &Scene<'_>,
    without: &World<'_>,
    with: &World<'_>,
    index: usize,
) -> Vec<Excess> {
    let by = Some(scene.activity(index).id);
    excesses(scene, without, with).into_iter().map(|broken| listed(by, broken)).collect()
}

pub(crate) fn listed(by: Option<ActivityId>, broken: Broken) -> Excess {
    let amount = i64::try_from(broken.amount).unwrap_or(i64::MAX);
    Excess { by, limit: broken.limit, at: time(broken.at), amount }
}
