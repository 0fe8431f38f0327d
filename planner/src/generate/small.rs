//! The small world: all of it on a grid, so that an exact solver's model of it
//! is the planner's own.
//!
//! Of starts, too: what the charge leaves would begin between two points of the
//! grid, and a plan would be worth more than the best on it. So each start
//! range is one instant.

use std::collections::BTreeSet;

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;

use crate::draws::Draws;
use crate::parameters::{Parameters, Phase, PreheatRow, Zone};
use crate::plan::{Activity, Dependency, Plan, StartRange, Status};
use crate::state::{State, Window};
use crate::units::{Bytes, Ppm, Span, Time};

use super::activities::{MANDATORY, MB, MINUTE, id, unsigned};
use super::worlds::{computer, load, watt_hours, watts};
use super::{Shape, World};

/// The grid's.
const STEP: i64 = 10 * MINUTE;
/// Resource bits.
const BITS: usize = 4;

fn at(step: i64) -> Time {
    Time::new(step * STEP)
}

/// As crowded in any size: ten minutes for each activity, and a few hours.
pub(super) fn small(shape: Shape) -> World {
    let mut draws = Draws::new(shape.seed);
    let count = i64::try_from(shape.activities).unwrap_or(i64::MAX);
    let end = 16 + count;
    let windows = [1, 3].map(|quarter| pass(end * quarter / 4, &mut draws)).into();
    let plan = Plan {
        name: format!("{} activities on a grid, seed {}", shape.activities, shape.seed),
        handover: at(end - draws.between(2, 6)),
        handover_min_soc: Ppm::new(500_000),
        end: at(end),
        max_delta_data: Bytes::new(draws.between(4, 8) * count * MB),
        next_plan: None,
        activities: wishes(shape, end, &mut draws),
    };
    let state = State {
        now: Time::ZERO,
        mode_since: at(-12),
        // Between too little for many and enough for most.
        charge: watt_hours(unsigned(draws.between(19, 23) * end / 2)),
        capacity: watt_hours(15 * unsigned(end)),
        windows,
        ..State::default()
    };
    World { plan, parameters: parameters(), state }
}

/// An orbiter's pass, early in the quarter that begins then.
fn pass(quarter: i64, draws: &mut Draws) -> Window {
    let start = quarter + draws.between(0, 3);
    Window {
        name: format!("pass at step {start}"),
        start: at(start),
        end: at(start + draws.between(1, 2)),
        awake: true,
        marginal: watts(30),
        peak: watts(60),
        data: Bytes::new(-draws.between(20, 40) * MB),
        engines: 1,
        resources: Categories::NONE,
    }
}

fn parameters() -> Parameters {
    let phase = Phase { duration: Span::new(STEP), load: load(40, 60) };
    let row = |(hour, minutes)| PreheatRow {
        from: Span::from_mins(60 * hour),
        duration: Span::from_mins(minutes),
    };
    let zone = |name: &str, load, rows: [(i64, i64); 3]| Zone {
        name: name.into(),
        load,
        table: rows.map(row).into(),
    };
    Parameters {
        // What is over is lost: a sleep that ends at a largest charge would end
        // between two points of the grid.
        max_soc: Ppm::new(1_000_000),
        awake: load(60, 60),
        peak_limit: watts(190),
        engines: 3,
        wakeup: phase,
        shutdown: phase,
        min_awake: Span::new(2 * STEP),
        min_sleep: Span::new(3 * STEP),
        zones: vec![
            zone("mast", load(20, 25), [(0, 30), (3, 20), (6, 10)]),
            zone("arm", load(35, 40), [(0, 50), (4, 30), (7, 20)]),
        ],
        resources: (0_u8..).take(BITS).map(|bit| (format!("bit {bit}"), bit)).collect(),
        ..computer()
    }
}

/// Generic activities, worth something that has little to do with what they
/// cost.
fn wishes(shape: Shape, end: i64, draws: &mut Draws) -> Vec<Activity> {
    let mut all: Vec<Activity> = Vec::with_capacity(shape.activities);
    for number in 0..shape.activities {
        let mut one = wish(number, end, shape.draw, draws);
        if let Some(before) = all.last_mut() {
            relate(before, &mut one, draws);
        }
        all.push(one);
    }
    all
}

fn wish(number: usize, end: i64, draw: u64, draws: &mut Draws) -> Activity {
    let mut one = Activity::new(id(number), Span::new(draws.between(1, 5) * STEP));
    let mandatory = draws.percent(8);
    let priority = if mandatory { draws.between(MANDATORY, 150) } else { draws.between(1, 100) };
    one.priority = u32::try_from(priority).unwrap_or(0);
    let watts = unsigned(draws.between(1, 12));
    (one.marginal, one.peak) =
        (Milliwatts::new(watts * 30 * draw), Milliwatts::new(watts * 60 * draw));
    one.data = Bytes::new(draws.between(0, 20) * MB);
    one.engines = u32::from(draws.percent(70));
    one.resources = Categories::from_mask(1 << draws.below(BITS));
    one.zones = match draws.below(100) {
        0..15 => vec!["mast".into()],
        15..25 => vec!["arm".into()],
        _ => Vec::new(),
    };
    one.starts = starts(one.duration, end, draws);
    one
}

/// Each step of one or two spans.
fn starts(duration: Span, end: i64, draws: &mut Draws) -> Vec<StartRange> {
    let last = end - duration.get() / STEP;
    let mut steps = BTreeSet::new();
    for _ in 0..=draws.below(2) {
        let from = draws.between(2, last);
        steps.extend(from..=last.min(from + draws.between(0, 12)));
    }
    let range = |from| StartRange { from, to: from, cutoff: from.after(duration) };
    steps.into_iter().map(at).map(range).collect()
}

/// What it has to do with the one before it in the plan.
fn relate(before: &mut Activity, one: &mut Activity, draws: &mut Draws) {
    let optional = |one: &Activity| i64::from(one.priority) < MANDATORY;
    match draws.below(100) {
        0..10 => {
            one.after = vec![Dependency { prior: before.id, statuses: vec![Status::Succeeded] }];
            // A dependant is never the more important one.
            one.priority = one.priority.min(before.priority);
        }
        10..20 if optional(before) && optional(one) => {
            let group = before.group.get_or_insert_with(|| before.id.to_string());
            one.group = Some(group.clone());
        }
        _ => {}
    }
}
