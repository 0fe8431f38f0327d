//! Broken planners: for each rule one that breaks just that, and is caught.
//!
//! A planner with a limit one off answers as a right one would that was asked
//! about another world: so the world is changed, the planner asked, and its
//! answer held against the world as it was. What no question can bring about is
//! done to the answer.

use faregate_agents::Categories;
use faregate_checker::{Effort, Rule, Violation, check};
use faregate_planner::plan::{Kind, StartRange};
use faregate_planner::timed::{Excess, Fate, Limit, Reason, TimedPlan};
use faregate_planner::units::{Bytes, Ppm, Span};
use faregate_planner::{Parameters, Problem, schedule};
use faregate_tickets::amount::Milliwatts;

use crate::executions;
use crate::worlds::{TINY, World, world};

/// What is broken about the planner.
#[derive(Clone, Copy)]
pub(crate) enum Mutant {
    /// It takes the world for another one.
    Asked(fn(&mut World)),
    /// It says something else than it should.
    Answered(fn(&World, &mut TimedPlan)),
    /// It forgets the plan that is being executed.
    Forgetful,
    /// The control thread does, or records, something else than it should.
    Executed(executions::Change),
}

use Mutant::{Answered, Asked, Executed, Forgetful};

/// Which rule catches which mutant.
const MUTANTS: &[(Rule, &str, Mutant)] = &[
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
    (Rule::Heating, "heated 1 ms too short", Asked(|world| heated(world, -1))),
    (
        Rule::Heating,
        "no heating",
        Asked(|world| {
            for zone in &mut world.parameters.zones {
                zone.table.clear();
            }
        }),
    ),
    (Rule::HeatedTwice, "heated 1 ms too long", Asked(|world| heated(world, 1))),
    (
        Rule::HeatedTwice,
        "heated twice",
        Answered(|_, timed| {
            let last = timed.preheats.last().cloned();
            timed.preheats.extend(last);
        }),
    ),
    (
        Rule::Computer,
        "down 1 ms early",
        Answered(|_, timed| {
            for phase in &mut timed.awake {
                let one = Span::new(1);
                (phase.down, phase.asleep) = (phase.down.before(one), phase.asleep.before(one));
            }
        }),
    ),
    (
        Rule::Computer,
        "asleep in windows",
        Asked(|world| {
            for window in &mut world.state.windows {
                window.awake = false;
            }
        }),
    ),
    (
        Rule::Manual,
        "a manual shutdown is an activity like others",
        Asked(|world| {
            each(world, |activity| {
                if let Kind::ManualShutdown { .. } = activity.kind {
                    activity.kind = Kind::StayAwake;
                    activity.priority = 10;
                }
            });
        }),
    ),
    (
        Rule::Wakeup,
        "wakeups 1 ms short",
        Asked(|world| {
            shorter(&mut world.parameters.wakeup.duration);
        }),
    ),
    (
        Rule::Shutdown,
        "shutdowns 1 ms short",
        Asked(|world| {
            shorter(&mut world.parameters.shutdown.duration);
        }),
    ),
    (
        Rule::Shutdown,
        "shutdowns are forgotten",
        Answered(|_, timed| {
            for phase in &mut timed.awake {
                phase.asleep = phase.down;
            }
        }),
    ),
    (
        Rule::MinAwake,
        "awake 1 ms too short",
        Asked(|world| {
            shorter(&mut world.parameters.min_awake);
        }),
    ),
    (
        Rule::MinSleep,
        "asleep 1 ms too short",
        Asked(|world| {
            shorter(&mut world.parameters.min_sleep);
        }),
    ),
    (
        Rule::Full,
        "sleeps past the maximum",
        Asked(|world| {
            let most = &mut world.parameters.max_soc;
            *most = Ppm::new(most.get() + 20_000);
        }),
    ),
    (
        Rule::Generated,
        "the computer draws 1 W less",
        Asked(|world| {
            let load = &mut world.parameters.awake.marginal;
            *load = load.saturating_sub(Milliwatts::from_watts(1));
        }),
    ),
    (
        Rule::Generated,
        "a full battery is not full",
        Asked(|world| {
            world.parameters.max_soc = Ppm::new(1_000_000);
        }),
    ),
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
    (Rule::Dispatched, "starts before its range", Executed(executions::before_its_range)),
    (Rule::DispatchedAfter, "does not wait", Executed(executions::prior_fails)),
    (Rule::DispatchedWarm, "a zone is not ok", Executed(executions::cold)),
    (Rule::DispatchedWarm, "a zone is truly cold", Executed(executions::truly_cold)),
    (Rule::DispatchedVariables, "a variable is unknown", Executed(executions::unknown)),
    (Rule::DispatchedAwake, "the computer goes down", Executed(executions::goes_down)),
    (Rule::RanResources, "bits are not looked at", Executed(executions::shares_bits)),
    (Rule::RanEngines, "engines are not counted", Executed(executions::too_many_engines)),
    (Rule::RanPeak, "peaks are not counted", Executed(executions::too_much_peak)),
    (Rule::RanPastCutoff, "runs 1 ms past its cutoff", Executed(executions::past_cutoff)),
    (Rule::RanAtHardLimit, "an estimate is ignored", Executed(executions::below_hard)),
    (Rule::RanAtHardLimit, "estimates are wrong", Executed(executions::truly_below_hard)),
    (Rule::RanBelowSoft, "optional ones go on", Executed(executions::below_soft)),
    (Rule::RanPastDuration, "an optional one goes on", Executed(executions::past_duration)),
    (Rule::AbortCause, "aborts without need", Executed(executions::aborted_for_nothing)),
    (Rule::AbortSafed, "does not revoke", Executed(executions::not_revoked)),
    (Rule::AbortSafed, "does not make safe", Executed(executions::not_safed)),
    (Rule::Paused, "pauses what cannot be", Executed(executions::paused)),
    (Rule::CleanupAfter, "cleans up for nothing", Executed(executions::cleans_up)),
    (Rule::RanGroup, "starts two of a group", Executed(executions::two_of_a_group)),
    (Rule::Recommitted, "replans at once", Executed(executions::recommitted)),
    (Rule::InOrder, "records late", Executed(executions::out_of_order)),
    (Rule::Fate, "loses one", Executed(executions::loses_one)),
    (Rule::Fate, "starts one twice", Executed(executions::twice)),
];

/// The planner as it is.
const UNCHANGED: Mutant = Asked(|_| {});

/// So many worlds are tried for each.
const WORLDS: u64 = 6_000;

#[test]
fn every_rule_has_a_mutant() {
    let without: Vec<&Rule> =
        Rule::ALL.iter().filter(|rule| !MUTANTS.iter().any(|(of, ..)| of == *rule)).collect();
    assert_eq!(without, [&Rule::Rows; 0]);
}

#[test]
fn every_mutant_is_caught_by_its_rule() {
    let mut missed = Vec::new();
    for (rule, name, mutant) in MUTANTS {
        let caught = (0..WORLDS).find(|seed| {
            let found = answers(*seed, *mutant, *rule);
            // A planner that breaks the rule by itself proves nothing.
            let breaks = |found: &[Violation]| found.iter().any(|v| v.rule == *rule);
            breaks(&found) && !breaks(&answers(*seed, UNCHANGED, *rule))
        });
        match caught {
            Some(seed) => println!("{rule:?}: \"{name}\" is caught in world {seed}"),
            None => missed.push((rule, name)),
        }
    }
    assert!(missed.is_empty(), "not caught in {WORLDS} worlds: {missed:?}");
}

/// What the checker says of a mutant's answer.
fn answers(seed: u64, mutant: Mutant, rule: Rule) -> Vec<Violation> {
    let world = world(seed, TINY);
    let grid = if rule == Rule::Sleep { 200 } else { 0 };
    let checked = |timed: &TimedPlan, incumbent: Option<&TimedPlan>| {
        let World { plan, parameters, state } = &world;
        check(plan, parameters, state, incumbent, timed, Effort { grid })
    };
    match mutant {
        Asked(change) => {
            let mut other = world.clone();
            change(&mut other);
            planned(&other).map_or_else(Vec::new, |timed| checked(&timed, None))
        }
        Answered(change) => {
            let Some(mut timed) = planned(&world) else { return Vec::new() };
            change(&world, &mut timed);
            checked(&timed, None)
        }
        Forgetful => {
            let mut poorer = world.clone();
            each(&mut poorer, |activity| activity.duration = activity.placed());
            let plans = planned(&world).zip(planned(&poorer));
            plans.map_or_else(Vec::new, |(timed, incumbent)| checked(&timed, Some(&incumbent)))
        }
        Executed(change) => executions::changed(seed, change),
    }
}

/// What the planner answers; nothing where the world makes no sense.
fn planned(world: &World) -> Option<TimedPlan> {
    let problem = Problem::new(&world.plan, &world.parameters, &world.state).ok()?;
    Some(schedule(&problem, None))
}

fn each(world: &mut World, change: impl FnMut(&mut faregate_planner::Activity)) {
    world.plan.activities.iter_mut().for_each(change);
}

fn ranges(world: &mut World, mut change: impl FnMut(&mut StartRange)) {
    each(world, |activity| {
        if !matches!(activity.kind, Kind::ManualShutdown { .. }) {
            activity.starts.iter_mut().for_each(&mut change);
        }
    });
}

fn expanding(world: &mut World, mut change: impl FnMut(&mut Span, &mut Span)) {
    each(world, |activity| {
        if let Kind::Expanding { minimum } = &mut activity.kind {
            change(&mut activity.duration, minimum);
        }
    });
}

fn heated(world: &mut World, by: i64) {
    for zone in &mut world.parameters.zones {
        for row in &mut zone.table {
            row.duration = Span::new((row.duration.get() + by).max(0));
        }
    }
}

fn shorter(span: &mut Span) {
    *span = Span::new((span.get() - 1).max(0));
}

fn lower(limit: &mut Ppm, by: i64) {
    *limit = Ppm::new((limit.get() - by).max(0));
}

fn out() -> Fate {
    Fate::Out(Reason::NoRangeLeft)
}

fn change_row(
    timed: &mut TimedPlan,
    which: impl Fn(&Fate) -> bool,
    change: impl Fn(&Fate) -> Fate,
) {
    if let Some(row) = timed.rows.iter_mut().find(|row| which(&row.fate)) {
        row.fate = change(&row.fate);
    }
}
