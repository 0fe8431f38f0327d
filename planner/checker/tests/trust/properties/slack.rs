//! More room, and the plan that was made with less.

use faregate_planner::schedule::{Budget, Worth};
use faregate_planner::units::{Bytes, Ppm, Span};
use faregate_tickets::amount::Milliwatts;

use super::{Planner, Said, problem, told};
use crate::worlds::{TINY, World, world};

/// What there is more of, and how it is made more.
type More = (&'static str, fn(&mut World));

/// Each leaves everything that is derived from a plan as it was.
const MORE: [More; 7] = [
    ("peak", |world| {
        let limit = &mut world.parameters.peak_limit;
        *limit = limit.saturating_add(Milliwatts::from_watts(40));
    }),
    ("data", |world| {
        world.plan.max_delta_data = Bytes::new(world.plan.max_delta_data.get() + 50);
    }),
    ("soft minimum", |world| {
        world.parameters.soft_min_soc = Ppm::new(world.parameters.soft_min_soc.get() / 2);
    }),
    ("handover minimum", |world| {
        world.plan.handover_min_soc = Ppm::new(world.plan.handover_min_soc.get() / 2);
    }),
    ("engines", |world| world.parameters.engines += 1),
    ("ranges", |world| {
        for activity in &mut world.plan.activities {
            // A manual shutdown has a time, and no range.
            if matches!(activity.kind, faregate_planner::plan::Kind::ManualShutdown { .. }) {
                continue;
            }
            for range in &mut activity.starts {
                range.to = range.to.after(Span::new(10));
                range.cutoff = range.cutoff.after(Span::new(20));
            }
        }
    }),
    ("timelines", |world| {
        for line in &mut world.parameters.timelines {
            line.max += 2;
        }
    }),
];

/// With more slack and the old plan, nothing is worth less. Says how often it
/// was worth more.
pub(super) fn never_costs(seed: u64, planner: Planner) -> Said {
    let world = world(seed, TINY);
    let timed = (planner.schedule)(&problem(&world), None);
    let mut better = 0;
    for (which, change) in MORE {
        let mut slack = world.clone();
        change(&mut slack);
        let problem = problem(&slack);
        let worth = |timed: &_| Worth::of(&problem, timed);
        let before = worth(&timed);
        let budget = Budget { evaluations: 60, seed };
        let improved = worth(&(planner.improve)(&problem, Some(&timed), budget).timed);
        let again = worth(&(planner.schedule)(&problem, Some(&timed)));
        if improved < before || again < before {
            let told = told(&world, &timed);
            return Err(format!("{which}: {before:?}, then {improved:?} {again:?}: {told}"));
        }
        better += usize::from(improved > before);
    }
    Ok(better)
}
