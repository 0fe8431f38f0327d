//! What windows, running activities and manual shutdowns break by themselves is
//! listed as the checker finds it, and one that is not broken is not.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_checker::{Effort, Rule, check, reference};
use faregate_planner::plan::Kind;
use faregate_planner::state::{Mode, Running, Window};
use faregate_planner::timed::Limit;
use faregate_planner::units::{Bytes, Time};
use faregate_planner::{Problem, TimedPlan, schedule};
use fastrand::Rng;

use crate::brute::{seeds, told};
use crate::explained::crowded;
use crate::worlds::World;

/// A world in which more runs, and passes overhead, than can be.
fn overloaded(seed: u64) -> World {
    let mut world = crowded(seed);
    let mut rng = Rng::with_seed(seed);
    let state = &mut world.state;
    let now = state.now;
    state.mode = Mode::Awake;
    let is_known = |id| {
        let ended = state.ended.iter().map(|it| it.id);
        ended.chain(state.running.iter().map(|it| it.id)).any(|other| other == id)
    };
    let open = world.plan.activities.iter().filter(|it| !is_known(it.id));
    let open: Vec<_> = open.filter(|it| it.kind == Default::default()).collect();
    let runs = open.into_iter().filter(|_| rng.bool()).map(|it| {
        let ends = now.after(it.duration);
        Running { id: it.id, started: now, ends, cutoff: ends, paused: None, data: Bytes::ZERO }
    });
    let runs: Vec<_> = runs.collect();
    state.running.extend(runs);
    let blocks = world.plan.activities.iter();
    let blocks = blocks.filter(|it| matches!(it.kind, Kind::ManualShutdown { .. }));
    for block in blocks {
        // Before it, in it, or over one of its ends.
        let start = Time::new(block.starts[0].from.get() + rng.i64(-10..20));
        let end = Time::new(start.get() + rng.i64(1..20));
        state.windows.push(Window { start, end, awake: true, ..pass("block") });
    }
    for number in 0..rng.usize(0..3) {
        let start = Time::new(now.get() + rng.i64(0..60));
        state.windows.push(Window {
            start,
            end: Time::new(start.get() + rng.i64(0..30)),
            awake: rng.u8(0..3) == 0,
            engines: rng.u32(0..3),
            resources: Categories::from_mask(u128::from(rng.u8(0..16))),
            ..pass(&number.to_string())
        });
    }
    world
}

/// It takes nothing.
fn pass(name: &str) -> Window {
    Window {
        name: name.to_owned(),
        start: Time::ZERO,
        end: Time::ZERO,
        awake: false,
        marginal: Default::default(),
        peak: Default::default(),
        data: Bytes::ZERO,
        engines: 0,
        resources: Default::default(),
    }
}

fn planned(world: &World) -> Option<TimedPlan> {
    let problem = Problem::new(&world.plan, &world.parameters, &world.state).ok()?;
    Some(schedule(&problem, None))
}

/// The checker's complaints about what is listed.
fn complaints(world: &World, timed: &TimedPlan) -> usize {
    let World { plan, parameters, state } = world;
    let all = check(plan, parameters, state, None, timed, Effort { grid: 0 });
    all.iter().filter(|it| it.rule == Rule::Unavoidable).count()
}

const fn kind(limit: &Limit) -> &'static str {
    match limit {
        Limit::SoftMinimum => "soft minimum",
        Limit::Handover => "handover",
        Limit::Data => "data",
        Limit::Peak => "peak",
        Limit::Engines => "engines",
        Limit::Resources(_) => "bits",
        Limit::Timeline(_) => "timeline",
        Limit::Computer => "computer",
        _ => "other",
    }
}

#[test]
fn what_is_unavoidable_is_listed_with_when_and_by_how_much() {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    for seed in 0..seeds(600) {
        let world = overloaded(seed);
        let Some(timed) = planned(&world) else { continue };
        let World { plan, parameters, state } = &world;
        let slow = reference(plan, parameters, state, None);
        assert_eq!(timed.unavoidable, slow.unavoidable, "seed {seed}: {}", told(&world, &timed));
        assert_eq!(complaints(&world, &timed), 0, "seed {seed}");
        for excess in &timed.unavoidable {
            *seen.entry(kind(&excess.limit)).or_default() += 1;
            // The control: not listed, or listed a millisecond off.
            let mut wrong = timed.clone();
            wrong.unavoidable.retain(|other| other != excess);
            assert_eq!(complaints(&world, &wrong), 1, "seed {seed}: {excess:?}");
            for other in wrong.unavoidable.iter_mut().take(1) {
                other.at = Time::new(other.at.get() + 1);
                let late = TimedPlan { unavoidable: vec![other.clone()], ..timed.clone() };
                assert!(complaints(&world, &late) > 0, "seed {seed}: {other:?}");
            }
        }
    }
    println!("{seen:?}");
    for kind in ["soft minimum", "handover", "peak", "engines", "bits", "timeline", "computer"] {
        assert!(seen.get(kind).is_some_and(|count| *count > 10), "{kind}: {seen:?}");
    }
}
