//! What is counted, or told, wrongly.

use faregate_checker::Rule;
use faregate_planner::Parameters;
use faregate_planner::plan::StartRange;
use faregate_planner::timed::{Excess, Fate, Limit, Reason};
use faregate_planner::units::Span;
use faregate_tickets::amount::Milliwatts;

use super::Entry;
use super::Mutant::{Answered, Asked, Forgetful};
use super::changes::{change_row, lower, out};
use crate::worlds::World;

/// Which rule catches which mutant.
pub(super) const MUTANTS: &[Entry] = &[
    (
        Rule::SoftMinimum,
        "1 % below the soft minimum",
        Asked(|world| {
            lower(&mut world.parameters.soft_min_soc, 10_000);
        }),
    ),
    (
        Rule::SoftMinimum,
        "preheats cost nothing",
        Asked(|world| {
            for zone in &mut world.parameters.zones {
                zone.load.marginal = Milliwatts::ZERO;
            }
        }),
    ),
    (
        Rule::SoftMinimum,
        "base load is 2 W less",
        Asked(|world| {
            let base = &mut world.parameters.base;
            *base = base.saturating_sub(Milliwatts::from_watts(2));
        }),
    ),
    (
        Rule::Handover,
        "1 % below the handover minimum",
        Asked(|world| {
            lower(&mut world.plan.handover_min_soc, 10_000);
        }),
    ),
    (
        Rule::Handover,
        "all are taken for mandatory",
        Asked(|world| {
            world.parameters.mandatory_from = 0;
        }),
    ),
    (Rule::Commit, "the commit window is forgotten", Forgetful),
    (Rule::Excess, "what is exceeded is not listed", Answered(|_, timed| timed.excess.clear())),
    (
        Rule::Excess,
        "somebody else is blamed",
        Answered(|world, timed| {
            let optional = |world: &World, p: &Parameters| {
                world.plan.activities.iter().find(|a| a.priority < p.mandatory_from).map(|a| a.id)
            };
            for excess in &mut timed.excess {
                excess.by = optional(world, &world.parameters);
            }
        }),
    ),
    (
        Rule::Unavoidable,
        "what cannot be helped is not listed",
        Answered(|_, timed| {
            timed.unavoidable.clear();
        }),
    ),
    (
        Rule::Unavoidable,
        "what is not so is listed",
        Answered(|world, timed| {
            if timed.unavoidable.is_empty() {
                let limit = Limit::Engines;
                let at = world.state.now;
                timed.unavoidable.push(Excess { by: None, limit, at, amount: 1 });
            }
        }),
    ),
    (
        Rule::Sleep,
        "one is left out though it fits",
        Asked(|world| {
            if let Some(activity) = world.plan.activities.iter_mut().rev().find(|a| a.priority > 0)
            {
                let past = world.state.now.before(Span::new(1));
                activity.starts = vec![StartRange { from: past, to: past, cutoff: past }];
            }
        }),
    ),
    (
        Rule::Reason,
        "blames a group that it is not in",
        Answered(|_, timed| {
            let first = timed.rows[0].id;
            let left_out = |fate: &Fate| matches!(fate, Fate::Out(_));
            change_row(timed, left_out, |_| Fate::Out(Reason::GroupTaken(first)));
        }),
    ),
    (
        Rule::Reason,
        "says that no range is left",
        Answered(|_, timed| {
            let limit = |fate: &Fate| matches!(fate, Fate::Out(Reason::Limit { .. }));
            change_row(timed, limit, |_| out());
        }),
    ),
];
