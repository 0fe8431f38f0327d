//! What a timed plan says, in the checker's own terms.

use faregate_planner::plan::ActivityId;
use faregate_planner::timed::{Fate, Slot, TimedPlan};

use crate::computer::Phase;
use crate::heating::Heating;
use crate::scene::{How, Placed, Scene, block};
use crate::violation::{Rule, Violation};
use crate::world::World;

/// A timed plan as it is given, and what the rules make of its activities.
#[derive(Debug)]
pub(crate) struct Given<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) timed: &'a TimedPlan,
    /// With what the plan says is generated.
    pub(crate) world: World<'a>,
    /// With what the rules generate.
    pub(crate) derived: World<'a>,
    /// With what stands whatever is planned, alone.
    pub(crate) base: World<'a>,
}

impl<'a> Given<'a> {
    pub(crate) fn new(scene: &'a Scene<'a>, timed: &'a TimedPlan) -> Self {
        let placed: Vec<Placed> = timed.rows.iter().filter_map(|row| of(scene, row)).collect();
        let heatings = timed.preheats.iter().map(|preheat| Heating {
            zone: preheat.zone.as_str(),
            start: preheat.start.get(),
            end: preheat.end.get(),
        });
        let phases = timed.awake.iter().map(|phase| Phase {
            wakeup: phase.wakeup.get(),
            up: phase.up.get(),
            down: phase.down.get(),
            asleep: phase.asleep.get(),
        });
        let (heatings, phases) = (heatings.collect(), phases.collect());
        let world = World::generated(scene, placed.clone(), heatings, phases, Vec::new());
        let derived = World::new(scene, placed);
        Self { scene, timed, world, derived, base: World::base(scene) }
    }

    pub(crate) fn id(&self, placed: &Placed) -> ActivityId {
        self.scene.activity(placed.index).id
    }

    /// What the planner has chosen.
    pub(crate) fn chosen(&self) -> impl Iterator<Item = &Placed> + Clone {
        self.world.placed.iter().filter(|placed| placed.how == How::Chosen)
    }

    /// What somebody has chosen: now, or in the plan that is being executed.
    pub(crate) fn decided(&self) -> impl Iterator<Item = &Placed> + Clone {
        let decided = |placed: &&Placed| matches!(placed.how, How::Chosen | How::Committed);
        self.world.placed.iter().filter(decided)
    }

    /// What is left out, by its place in the plan.
    pub(crate) fn left_out(&self) -> impl Iterator<Item = usize> {
        let rows = self.timed.rows.iter().enumerate();
        rows.filter(|(_, row)| matches!(row.fate, Fate::Out(_))).map(|(index, _)| index)
    }

    /// The sleeps of the plan, first to last, without manual ones.
    pub(crate) fn sleeps(&self) -> Vec<(i64, i64)> {
        sleeps(self.scene, &self.world.phases)
    }
}

/// Where the computer sleeps, by these phases: not in manual blocks.
pub(crate) fn sleeps(scene: &Scene<'_>, phases: &[Phase]) -> Vec<(i64, i64)> {
    let begin = match crate::world::begin(scene) {
        crate::computer::Begin::Asleep { since } => since.max(scene.now),
        _ => scene.now,
    };
    let starts = [begin].into_iter().chain(phases.iter().map(|phase| phase.asleep));
    let ends = phases.iter().map(|phase| phase.wakeup).chain([scene.end]);
    let all = starts.zip(ends).filter(|(start, end)| start < end);
    let blocks = scene.manual();
    let manual = |at: i64| blocks.iter().any(|block| (block.start..block.end).contains(&at));
    all.filter(|(start, _)| !manual(*start)).collect()
}

/// A row as a placed activity.
fn of(scene: &Scene<'_>, row: &faregate_planner::timed::Row) -> Option<Placed> {
    let (Fate::Scheduled(slot) | Fate::Running(slot)) = row.fate else { return None };
    let index = scene.index(row.id)?;
    let (start, end) = (slot.start.get(), slot.end.get());
    let fixed = scene.fixed.iter().find(|fixed| fixed.index == index);
    // A fixed one that was moved is one that was chosen: badly.
    let same = fixed.filter(|fixed| (fixed.start, fixed.end) == (start, end));
    Some(Placed { index, start, end, how: same.map_or(How::Chosen, |fixed| fixed.how) })
}

/// Whether the rows are those of the plan, and true to the state.
pub(crate) fn rows(scene: &Scene<'_>, timed: &TimedPlan) -> Vec<Violation> {
    let expected: Vec<ActivityId> = scene.plan.activities.iter().map(|a| a.id).collect();
    let found: Vec<ActivityId> = timed.rows.iter().map(|row| row.id).collect();
    if expected != found {
        let detail = format!("{} activities, {} rows", expected.len(), found.len());
        return vec![Violation::new(Rule::Rows, None, scene.now).detail(detail)];
    }
    let wrong = timed.rows.iter().enumerate().filter_map(|(index, row)| {
        let wanted = wanted(scene, index, &row.fate)?;
        let violation = Violation::new(Rule::Rows, Some(row.id), scene.now);
        Some(violation.detail(format!("{wanted}, not {:?}", row.fate)))
    });
    wrong.collect()
}

/// What a row should have said, if it says something else.
fn wanted(scene: &Scene<'_>, index: usize, fate: &Fate) -> Option<String> {
    let activity = scene.activity(index);
    let running = scene.is_running(activity.id);
    let is = |slot: &Slot, placed: &Placed| {
        (slot.start.get(), slot.end.get()) == (placed.start, placed.end)
    };
    let fixed = scene.fixed.iter().find(|placed| placed.index == index);
    let right = match (scene.ended(activity.id), fixed, fate) {
        (Some(ended), _, Fate::Ended(outcome)) => ended.outcome == *outcome,
        (None, Some(placed), Fate::Running(slot)) => running && is(slot, placed),
        (None, Some(_), Fate::Scheduled(_)) => !running,
        (None, None, Fate::Scheduled(_)) => block(index, activity).is_none(),
        (None, fixed, Fate::Out(_)) => fixed.is_none() || !running,
        _ => false,
    };
    let ended = scene.ended(activity.id).map(|ended| format!("ended: {:?}", ended.outcome));
    let runs = fixed.filter(|_| running).map(|p| format!("runs from {} to {}", p.start, p.end));
    (!right).then(|| ended.or(runs).unwrap_or_else(|| "it is to be scheduled or left out".into()))
}
