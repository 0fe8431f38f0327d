//! The checker and the slowest planner agree: neither can be right alone.

use faregate_checker::{Effort, check, check_turns, reference};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::units::Time;

use crate::worlds::{TINY, World, world};

/// What is wrong with a plan, by all that the checker knows.
pub(crate) fn wrong(
    world: &World,
    incumbent: Option<&TimedPlan>,
    timed: &TimedPlan,
    effort: Effort,
) -> Vec<String> {
    let World { plan, parameters, state } = world;
    let mut all = check(plan, parameters, state, incumbent, timed, effort);
    all.extend(check_turns(plan, parameters, state, incumbent, timed));
    all.iter().map(ToString::to_string).collect()
}

#[test]
fn what_the_slowest_planner_makes_keeps_every_rule() {
    let (mut scheduled, mut out, mut phases, mut preheats) = (0, 0, 0, 0);
    for seed in 0..seeds(400) {
        let world = world(seed, TINY);
        let timed = reference(&world.plan, &world.parameters, &world.state, None);
        let wrong = wrong(&world, None, &timed, Effort { grid: 200 });
        assert_eq!(wrong, [""; 0], "seed {seed}: {}", told(&world, &timed));
        scheduled += timed.rows.iter().filter(|r| matches!(r.fate, Fate::Scheduled(_))).count();
        out += timed.rows.iter().filter(|r| matches!(r.fate, Fate::Out(_))).count();
        phases += timed.awake.len();
        preheats += timed.preheats.len();
    }
    println!("{scheduled} scheduled, {out} left out, {phases} phases, {preheats} preheats");
    assert!(scheduled > out / 3 && out > scheduled / 5, "{scheduled} {out}");
    assert!(phases > 400 && preheats > 100, "{phases} {preheats}");
}

/// So many, or as many as `SEEDS` says.
pub(crate) fn seeds(usual: u64) -> u64 {
    std::env::var("SEEDS").ok().and_then(|seeds| seeds.parse().ok()).unwrap_or(usual)
}

/// A world and its plan, in few lines.
pub(crate) fn told(world: &World, timed: &TimedPlan) -> String {
    let World { plan, parameters, state } = world;
    let awake: Vec<_> =
        timed.awake.iter().map(|p| [p.wakeup, p.up, p.down, p.asleep].map(Time::get)).collect();
    let rows: Vec<_> = timed.rows.iter().map(|row| format!("{:?}", row.fate)).collect();
    let activities = plan.activities.iter().zip(rows);
    let activities: Vec<_> = activities.map(|(a, row)| format!("{a:?}\n  -> {row}")).collect();
    let plan = format!(
        "handover {:?} {:?} end {:?} data {:?}",
        plan.handover, plan.handover_min_soc, plan.end, plan.max_delta_data
    );
    format!(
        "{plan}\n{parameters:?}\n{state:?}\n{}\nawake {awake:?}\n{:?}\n{:?}\n{:?}",
        activities.join("\n"),
        timed.preheats,
        timed.excess,
        timed.unavoidable
    )
}
