//! The planner, against the slowest planner and against the checker.

use faregate_checker::{Effort, reference};
use faregate_planner::timed::{AwakePhase, Fate, Reason, TimedPlan};
use faregate_planner::units::Time;
use faregate_planner::{Problem, schedule, schedule_in_order};

use crate::brute::{seeds, told, wrong};
use crate::worlds::{DAY, SOL, TINY, World, world};

/// What the planner answers.
pub(crate) fn planned(world: &World) -> TimedPlan {
    let World { plan, parameters, state } = world;
    let problem = Problem::new(plan, parameters, state);
    schedule(&problem.unwrap_or_else(|unfit| panic!("unfit: {unfit:?}")), None)
}

/// A plan without its reasons: of several that are true at once, or at
/// different turns.
pub(crate) fn bare(timed: &TimedPlan) -> TimedPlan {
    let mut timed = timed.clone();
    for row in &mut timed.rows {
        match &mut row.fate {
            Fate::Out(reason) => *reason = Reason::NoRangeLeft,
            // Which of its ranges it was started in, nobody knows any more.
            Fate::Running(slot) => slot.range = 0,
            Fate::Scheduled(_) | Fate::Ended(_) => {}
        }
    }
    timed
}

#[test]
fn in_small_worlds_it_answers_what_trying_every_start_answers() {
    let mut differing = Vec::new();
    let count = seeds(600);
    for seed in 0..count {
        let world = world(seed, TINY);
        let World { plan, parameters, state } = &world;
        let slow = reference(plan, parameters, state, None);
        let fast = planned(&world);
        if bare(&fast) != bare(&slow) {
            differing.push((seed, world, fast, slow));
        }
    }
    for (seed, world, fast, slow) in &differing {
        println!("seed {seed}: {}", difference(world, None, fast, slow));
    }
    let only = std::env::var("SEED").ok().and_then(|seed| seed.parse::<u64>().ok());
    let first = differing.iter().find(|(seed, ..)| only.is_none_or(|only| only == *seed));
    let Some((seed, world, fast, slow)) = first else { return };
    panic!("{} of {count} differ; seed {seed}: {}{}", differing.len(), told(world, slow), {
        difference(world, None, fast, slow)
    });
}

/// Where two plans differ first, and what the checker says of the first one.
pub(crate) fn difference(
    world: &World,
    incumbent: Option<&TimedPlan>,
    fast: &TimedPlan,
    slow: &TimedPlan,
) -> String {
    let rows = fast.rows.iter().zip(&slow.rows).filter(|(a, b)| a != b);
    let rows: Vec<String> =
        rows.map(|(a, b)| format!("\n  {} {:?}, but {:?}", a.id, a.fate, b.fate)).collect();
    let awake = |timed: &TimedPlan| -> Vec<[i64; 4]> {
        let ms = |p: &AwakePhase| [p.wakeup, p.up, p.down, p.asleep].map(Time::get);
        timed.awake.iter().map(ms).collect()
    };
    let (a, b) = (awake(fast), awake(slow));
    let heated: Vec<_> = [&fast.preheats, &slow.preheats].map(|p| format!("{p:?}")).into();
    let wrong = wrong(world, incumbent, fast, Effort { grid: 200 });
    let mut told = format!("{}\n  wrong: {wrong:?}", rows.join(""));
    if a != b {
        told += &format!("\n  awake {a:?}, but {b:?}");
    }
    if heated[0] != heated[1] {
        told += &format!("\n  heated {}, but {}", heated[0], heated[1]);
    }
    if fast.excess != slow.excess || fast.unavoidable != slow.unavoidable {
        told += &format!("\n  {:?} {:?}", fast.excess, fast.unavoidable);
        told += &format!(", but {:?} {:?}", slow.excess, slow.unavoidable);
    }
    told
}

/// A search that goes from millisecond to millisecond would be right, too, and
/// take days: it goes in steps that do not depend on how long a day is.
#[test]
fn days_of_any_length_are_searched_in_few_steps() {
    let steps = |scale| {
        (0..seeds(120)).map(move |seed| {
            let World { plan, parameters, state } = world(seed, scale);
            let problem = Problem::new(&plan, &parameters, &state).expect("it fits together");
            schedule_in_order(&problem, problem.order(), None).1
        })
    };
    let (mut short, mut long) = (0, 0);
    let mut most = 0;
    for (day, sol) in steps(DAY).zip(steps(SOL)) {
        (short, long) = (short + day.starts, long + sol.starts);
        most = most.max(sol.starts / sol.candidates.max(1));
    }
    println!("{short} starts tried in short days, {long} in long ones; {most} for each candidate");
    assert!(long < 2 * short, "{long} starts tried where {short} do in a shorter day");
    assert!(most < 1_000, "{most} starts tried for each candidate");
}
