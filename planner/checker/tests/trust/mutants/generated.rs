//! What is generated wrongly.

use faregate_checker::Rule;
use faregate_planner::plan::Kind;
use faregate_planner::units::{Ppm, Span};
use faregate_tickets::amount::Milliwatts;

use super::Entry;
use super::Mutant::{Answered, Asked};
use super::changes::{each, heated, shorter};

/// Which rule catches which mutant.
pub(super) const MUTANTS: &[Entry] = &[
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
];
