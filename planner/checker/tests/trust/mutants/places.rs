//! What is placed where it must not be.

use faregate_agents::Categories;
use faregate_checker::Rule;
use faregate_planner::plan::Kind;
use faregate_planner::timed::Fate;
use faregate_planner::units::{Bytes, Span};
use faregate_tickets::amount::Milliwatts;

use super::Entry;
use super::Mutant::{Answered, Asked};
use super::changes::{change_row, each, expanding, out, ranges};

/// Which rule catches which mutant.
pub(super) const MUTANTS: &[Entry] = &[
    (Rule::Rows, "the last row is missing", Answered(|_, timed| drop(timed.rows.pop()))),
    (
        Rule::Rows,
        "what runs is left out",
        Answered(|_, timed| {
            change_row(timed, |fate| matches!(fate, Fate::Running(_)), |_| out());
        }),
    ),
    (
        Rule::Range,
        "ranges begin 1 ms early",
        Asked(|world| {
            ranges(world, |range| range.from = range.from.before(Span::new(1)));
        }),
    ),
    (
        Rule::Range,
        "ranges end 1 ms late",
        Asked(|world| {
            ranges(world, |range| range.to = range.to.after(Span::new(1)));
        }),
    ),
    (
        Rule::Cutoff,
        "cutoffs are 1 ms late",
        Asked(|world| {
            ranges(world, |range| range.cutoff = range.cutoff.after(Span::new(1)));
        }),
    ),
    (
        Rule::End,
        "the plan ends 1 ms late",
        Asked(|world| {
            world.plan.end = world.plan.end.after(Span::new(1));
        }),
    ),
    (
        Rule::Duration,
        "durations are 1 ms short",
        Asked(|world| {
            for activity in &mut world.plan.activities {
                if activity.kind == Kind::Generic && activity.duration > Span::new(1) {
                    activity.duration = Span::new(activity.duration.get() - 1);
                }
            }
        }),
    ),
    (
        Rule::Expansion,
        "expands 1 ms too far",
        Asked(|world| {
            expanding(world, |duration, _| *duration = Span::new(duration.get() + 1));
        }),
    ),
    (
        Rule::Expansion,
        "a minimum is 1 ms short",
        Asked(|world| {
            expanding(world, |_, minimum| *minimum = Span::new((minimum.get() - 1).max(1)));
        }),
    ),
    (
        Rule::Dependency,
        "dependencies are forgotten",
        Asked(|world| {
            each(world, |activity| activity.after.clear());
        }),
    ),
    (
        Rule::Group,
        "groups are forgotten",
        Asked(|world| {
            each(world, |activity| activity.group = None);
        }),
    ),
    (
        Rule::Resources,
        "bits are forgotten",
        Asked(|world| {
            each(world, |activity| activity.resources = Categories::NONE);
        }),
    ),
    (Rule::Engines, "one engine too many", Asked(|world| world.parameters.engines += 1)),
    (
        Rule::Peak,
        "peaks 1 W too high",
        Asked(|world| {
            let limit = &mut world.parameters.peak_limit;
            *limit = limit.saturating_add(Milliwatts::from_watts(1));
        }),
    ),
    (
        Rule::Peak,
        "heaters have no peak",
        Asked(|world| {
            for zone in &mut world.parameters.zones {
                zone.load.peak = Milliwatts::ZERO;
            }
        }),
    ),
    (
        Rule::Data,
        "1 B too much",
        Asked(|world| {
            world.plan.max_delta_data = Bytes::new(world.plan.max_delta_data.get() + 1);
        }),
    ),
    (
        Rule::Timeline,
        "a limit 1 too high",
        Asked(|world| {
            for timeline in &mut world.parameters.timelines {
                timeline.max += 1;
                timeline.min -= 1;
            }
        }),
    ),
    (
        Rule::Timeline,
        "what is asked of timelines is forgotten",
        Asked(|world| {
            each(world, |activity| activity.constraints.clear());
        }),
    ),
];
