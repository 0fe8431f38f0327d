//! What would let an activity in does so at its turn, and one unit less of it
//! does not: each relaxation is made where its number stands, and the plan is
//! made again with everything that was placed by then held where it was.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_checker::reference;
use faregate_planner::explain::{Change, Explanation, Number, Relaxation, Whose, explain_all};
use faregate_planner::plan::{Constraint, Effect, Impact, Kind, StartRange};
use faregate_planner::timed::{Limit, Slot, TimedPlan};
use faregate_planner::units::Time;
use faregate_planner::{ActivityId, Problem, schedule};

use fastrand::Rng;

use crate::brute::seeds;
use crate::worlds::{TINY, World, world};

/// More than any number of these worlds.
const LOTS: i64 = 1 << 40;

/// Who makes the plan again, if that can be done.
type Planner = fn(&World) -> Option<TimedPlan>;

fn planned(world: &World) -> Option<TimedPlan> {
    let World { plan, parameters, state } = world;
    let problem = Problem::new(plan, parameters, state).ok()?;
    Some(schedule(&problem, None))
}

fn tried(world: &World) -> Option<TimedPlan> {
    Some(reference(&world.plan, &world.parameters, &world.state, None))
}

/// A world in which much is shared, so that each limit is in the way of
/// somebody.
pub(crate) fn crowded(seed: u64) -> World {
    let mut world = world(seed, TINY);
    let mut rng = Rng::with_seed(seed);
    for line in world.parameters.timelines.iter_mut().filter(|_| rng.bool()) {
        line.max = line.max.min(2).max(line.initial);
    }
    for activity in &mut world.plan.activities {
        let manual = matches!(activity.kind, Kind::ManualShutdown { .. });
        if manual || rng.u8(0..3) > 0 {
            continue;
        }
        let (name, effect) = match rng.u8(0..6) {
            0 => ("bus", Effect::Hold(1)),
            1 => ("seats", Effect::Hold(rng.i64(1..=2))),
            2 => ("mode", Effect::SetAtStart(rng.i64(0..=4))),
            3 => ("fuel", Effect::AddAtEnd(rng.i64(-9..=9))),
            4 => ("fuel", Effect::Rate(rng.i64(-900..=900))),
            _ => {
                let mask = u128::from(rng.u8(1..16));
                activity.resources = Categories::from_mask(mask);
                continue;
            }
        };
        activity.impacts.push(Impact { timeline: name.into(), effect });
        if rng.bool() {
            let (min, max) = (rng.i64(0..=1), rng.i64(1..=55));
            let timeline = if name == "fuel" { "fuel" } else { "mode" }.into();
            activity.constraints.push(Constraint { timeline, min, max });
        }
    }
    world
}

fn explained(world: &World) -> Vec<Explanation> {
    let problem = Problem::new(&world.plan, &world.parameters, &world.state);
    let problem = problem.unwrap_or_else(|unfit| panic!("unfit: {unfit:?}"));
    let mut all = explain_all(&problem, None, |_| true);
    all.retain(|one| one.turn.is_err());
    all
}

/// The world at an activity's turn: what was placed is held, and what had no
/// turn yet, or was left out, has no start.
fn at_its_turn(world: &World, told: &Explanation) -> World {
    let mut world = world.clone();
    let range = |slot: Option<Slot>| match slot {
        Some(Slot { start, end, .. }) => StartRange { from: start, to: start, cutoff: end },
        None => StartRange { from: Time::new(1), to: Time::new(0), cutoff: Time::new(0) },
    };
    for activity in &mut world.plan.activities {
        let manual = matches!(activity.kind, Kind::ManualShutdown { .. });
        if activity.id != told.id && !manual {
            activity.starts = vec![range(slot(told, activity.id))];
        }
    }
    world
}

fn slot(told: &Explanation, id: ActivityId) -> Option<Slot> {
    told.beside.iter().find(|(other, _)| *other == id).map(|(_, slot)| *slot)
}

/// When it starts at its turn after this change, if it does. `None`: nothing
/// can be said, since one of those that were placed is elsewhere now, or
/// nobody plans with such numbers.
fn start(
    world: &World,
    told: &Explanation,
    change: Option<&Relaxation>,
    planner: Planner,
) -> Option<Option<Time>> {
    let mut world = at_its_turn(world, told);
    if let Some(change) = change {
        change.apply(told.id, &mut world.plan, &mut world.parameters);
    }
    let timed = planner(&world)?;
    let is_block = |id: ActivityId| {
        let mut all = world.plan.activities.iter();
        all.any(|it| it.id == id && matches!(it.kind, Kind::ManualShutdown { .. }))
    };
    let held = |(id, slot): &(ActivityId, Slot)| {
        is_block(*id) || timed.slot(*id).is_some_and(|other| other.start == slot.start)
    };
    let all_held = told.beside.iter().all(held);
    all_held.then(|| timed.slot(told.id).map(|slot| slot.start))
}

/// The same with one unit less; each way in which that can be.
fn one_less(relaxation: &Relaxation) -> Vec<Option<Relaxation>> {
    let Some(change) = relaxation.change else { return Vec::new() };
    if change.number != Number::Without {
        let less = Change { by: change.by - 1, ..change };
        return vec![Some(Relaxation { change: Some(less), ..relaxation.clone() })];
    }
    let Limit::Resources(mask) = relaxation.limit else { return vec![None] };
    let bits = (0..128).map(|bit| 1_u128 << bit).filter(|bit| mask & bit != 0);
    let kept = bits
        .map(|bit| Relaxation { limit: Limit::Resources(mask & !bit), change: relaxation.change });
    kept.map(Some).collect()
}

/// What is untrue of a relaxation; `None`: nothing can be said.
fn wrong(
    world: &World,
    told: &Explanation,
    relaxation: &Relaxation,
    planner: Planner,
) -> Option<Vec<String>> {
    let mut wrong = Vec::new();
    let Some(change) = relaxation.change else { return Some(wrong) };
    let with = start(world, told, Some(relaxation), planner)?;
    if with != Some(change.start) {
        wrong.push(format!("it starts at {with:?}"));
    }
    for less in one_less(relaxation) {
        if let Some(at) = start(world, told, less.as_ref(), planner)? {
            wrong.push(format!("with one unit less it starts at {at:?}"));
        }
    }
    Some(wrong)
}

/// Where a limit stands in a list, whichever timeline it is.
fn rank(limit: &Limit) -> Limit {
    match limit {
        Limit::Timeline(_) => Limit::Timeline(String::new()),
        limit => limit.clone(),
    }
}

/// What is changed, in a word.
fn kind(relaxation: &Relaxation) -> Option<&'static str> {
    Some(match (relaxation.change?.number, &relaxation.limit) {
        (Number::Limit, Limit::SoftMinimum) => "soft minimum",
        (Number::Limit, Limit::Handover) => "handover",
        (Number::Limit, Limit::Data) => "data",
        (Number::Limit, Limit::Peak) => "peak",
        (Number::Limit, _) => "engines",
        (Number::Least(Whose::Timeline), _) => "least",
        (Number::Most(Whose::Timeline), _) => "most",
        (Number::Least(_) | Number::Most(_), _) => "constraint",
        (Number::From(_), _) => "opens",
        (Number::To(_), _) => "closes",
        (Number::Cutoff(_), _) => "cutoff",
        (Number::Shutdown(_), _) => "shutdown",
        (Number::Earlier(_) | Number::Later(_), _) => "moved shutdown",
        (Number::Heating(..), _) => "heating",
        (Number::Wakeup, _) => "wakeup",
        (Number::MinSleep, _) => "minimum sleep",
        (Number::Without, Limit::Resources(_)) => "bits",
        (Number::Without, Limit::Timeline(_)) => "unit",
        (Number::Without, Limit::Computer) => "no shutdown",
        (Number::Without, _) => "dependency",
    })
}

#[test]
fn each_relaxation_lets_it_in_at_its_turn_and_one_unit_less_does_not() {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let (mut untold, mut count) = (0, 0_usize);
    for seed in 0..seeds(1_200) {
        let world = crowded(seed);
        for told in explained(&world) {
            assert_eq!(start(&world, &told, None, planned), Some(None), "seed {seed}: {told:?}");
            let order: Vec<_> = told.relaxations.iter().map(|it| rank(&it.limit)).collect();
            assert!(order.is_sorted(), "seed {seed}: {told:?}");
            for relaxation in &told.relaxations {
                let Some(kind) = kind(relaxation) else { continue };
                count += 1;
                // Trying every millisecond takes long.
                let planner = if count.is_multiple_of(16) { tried } else { planned };
                let Some(wrong) = wrong(&world, &told, relaxation, planner) else {
                    untold += 1;
                    continue;
                };
                assert_eq!(wrong, [""; 0], "seed {seed}: {told:?}\n{relaxation:?}");
                *seen.entry(kind).or_default() += 1;
            }
        }
    }
    println!("{seen:?}, {untold} of {count} not to be told");
    for kind in [
        "soft minimum",
        "handover",
        "data",
        "peak",
        "engines",
        "bits",
        "least",
        "most",
        "constraint",
        "unit",
        "opens",
        "closes",
        "cutoff",
        "shutdown",
        "moved shutdown",
        "heating",
        "wakeup",
        "dependency",
    ] {
        assert!(seen.contains_key(kind), "none of {kind} in {seen:?}");
    }
    assert!(untold * 50 < count, "{untold} of {count}");
}

/// Limits that are not said to help, made as wide as can be.
fn in_vain(told: &Explanation) -> Vec<Relaxation> {
    let limits = [Limit::SoftMinimum, Limit::Handover, Limit::Data, Limit::Peak, Limit::Engines];
    let helps =
        |limit: &Limit| told.relaxations.iter().any(|it| it.limit == *limit && it.change.is_some());
    let wide = |limit: Limit| {
        let by = match limit {
            Limit::Engines => 1_000,
            Limit::SoftMinimum | Limit::Handover => 1_000_000,
            _ => LOTS,
        };
        let (number, start) = (Number::Limit, Time::ZERO);
        let change = Change { number, by, start, with: None, until: None };
        Relaxation { limit, change: Some(change) }
    };
    limits.into_iter().filter(|limit| !helps(limit)).map(wide).collect()
}

#[test]
fn what_is_not_said_to_help_does_not_however_much_of_it_there_is() {
    let mut count = 0;
    for seed in 0..seeds(200) {
        let world = crowded(seed);
        for told in explained(&world) {
            for mut relaxation in in_vain(&told) {
                // A minimum cannot be below nothing.
                let change = relaxation.change.as_mut().expect("there is one");
                match relaxation.limit {
                    Limit::SoftMinimum => change.by = world.parameters.soft_min_soc.get(),
                    Limit::Handover => change.by = world.plan.handover_min_soc.get(),
                    _ => {}
                }
                let at = start(&world, &told, Some(&relaxation), planned);
                let group =
                    matches!(told.turn, Err(faregate_planner::timed::Reason::GroupTaken(_)));
                assert!(group || at.is_none_or(|at| at.is_none()), "seed {seed}: {told:?}\n{at:?}");
                count += 1;
            }
        }
    }
    assert!(count > 500, "{count}");
}

#[test]
fn a_relaxation_that_is_one_unit_off_is_caught() {
    let mut caught = [0, 0];
    for seed in 0..seeds(60) {
        let world = crowded(seed);
        for told in explained(&world) {
            let numbers = told.relaxations.iter().filter_map(|it| Some((it, it.change?)));
            for (relaxation, change) in numbers.filter(|(_, it)| it.number != Number::Without) {
                for (off, count) in [-1, 1].into_iter().zip(&mut caught) {
                    let by = change.by + off;
                    let off =
                        Relaxation { change: Some(Change { by, ..change }), ..relaxation.clone() };
                    let Some(wrong) = wrong(&world, &told, &off, planned) else { continue };
                    assert!(!wrong.is_empty(), "seed {seed}: {told:?}\n{off:?}");
                    *count += 1;
                }
            }
        }
    }
    assert!(caught.iter().all(|count| *count > 50), "{caught:?}");
}
