//! Random executions: a world, plans for it, and what goes wrong, all drawn from
//! one number, so that each can be seen again by that number alone.
//!
//! The worlds are those of the planner's generator with little in them, so that
//! many can be executed: five to thirty activities, and what the generator has
//! too seldom for executions. Batteries are small and limits near, so that they
//! are met; some cutoffs leave no room; priors that fail have cleanups; some
//! plans are followed by another one.

mod activities;
mod world;

use std::sync::Arc;

use faregate_devices_sim::rover::Senses;
use faregate_planner::execute::Options;
use faregate_planner::generate::{Shape, World};
use faregate_planner::units::{Span, Time};
use faregate_planner::{ActivityId, Plan};
use faregate_tickets::amount::Microjoules;
use faregate_tickets::clock::Duration;

use crate::script::Script;
use crate::sequences::Sequences;
use crate::throws::Throws;
use crate::{Draws, Odds, Setup};

/// The numbers of a next plan's activities: most are not the first plan's.
const NEXT: u32 = 1_000;

impl Setup {
    /// The execution of a seed: plan, parameters, state, and all that goes
    /// wrong.
    #[must_use]
    pub fn random(seed: u64) -> Self {
        let mut throws = Throws::new(seed, 1 << 42);
        let mut sequences = Sequences::none();
        let World { mut plan, mut parameters, mut state } = shape(&mut throws, seed).draw();
        world::parameters(&mut parameters, &mut throws);
        world::state(&mut state, &parameters, &mut throws);
        world::plan(&mut plan, &state, &mut throws);
        activities::change(&mut plan, &mut sequences, &mut throws);
        activities::manual_block(&mut plan, &state, &mut throws);
        let followed = throws.chance(45);
        let next = followed.then(|| next(seed, &mut plan, state.now, &mut sequences, &mut throws));
        let odds = odds(&mut throws);
        let mut draws = Draws::new(&plan, seed, &odds);
        if let Some(next) = &next {
            draws.add(next, seed, &odds);
        }
        // Now and then it is not there, though the plan names it.
        let next = next.filter(|_| throws.chance(85)).map(Arc::new);
        Self {
            script: Script::drawn(&plan, &parameters, &state, seed),
            senses: senses(state.capacity, &mut throws),
            options: Options {
                period: throws.minutes(10, 60),
                charge_holds: throws.minutes(3, 30),
                ..Options::default()
            },
            draws,
            sequences,
            next,
            ..Self::new(Arc::new(plan), Arc::new(parameters), state, seed)
        }
    }
}

fn shape(throws: &mut Throws, seed: u64) -> Shape {
    let activities = throws.index(5, 30);
    let draw = throws.one_of(&[60, 100, 150, 200]);
    Shape { draw, ..Shape::sols(activities, seed) }
}

/// The plan that follows, for the same rover: what began before its time is
/// over, and is not started.
fn next(
    seed: u64,
    plan: &mut Plan,
    now: Time,
    sequences: &mut Sequences,
    throws: &mut Throws,
) -> Plan {
    let mut next = shape(throws, !seed).draw().plan;
    next.end = plan.end.after(throws.minutes(0, 240));
    next.handover = next.end;
    activities::change(&mut next, sequences, throws);
    if throws.chance(90) {
        renumber(&mut next);
    }
    plan.next_plan = Some("next".into());
    plan.handover = throws.within(now.after(Span::from_mins(60)), plan.handover);
    next
}

fn renumber(plan: &mut Plan) {
    let other = |id: ActivityId| ActivityId::new(id.get().saturating_add(NEXT)).unwrap_or(id);
    for activity in &mut plan.activities {
        activity.id = other(activity.id);
        activity.after.iter_mut().for_each(|prior| prior.prior = other(prior.prior));
    }
}

/// Some days are as usual, most are bad, each in its own way.
fn odds(throws: &mut Throws) -> Odds {
    match throws.index(0, 9) {
        0 => Odds::NONE,
        1 | 2 => Odds::default(),
        3 | 4 => Odds::HARSH,
        _ => Odds {
            fail: throws.number(0, 250),
            overrun: throws.number(50, 500),
            shortest: throws.number(200, 950),
            longest: throws.number(1_050, 4_000),
            power: (throws.number(500, 1_000), 1_000),
            data: (throws.number(300, 1_000), 1_050),
        },
    }
}

/// Often and exactly, or now and then and badly.
fn senses(capacity: Microjoules, throws: &mut Throws) -> Senses {
    Senses {
        period: Duration::from_secs(throws.number(20, 120)),
        lag: Duration::from_millis(throws.number(0, 8_000)),
        charge_noise: Microjoules::new(capacity.get() / 1_000 * throws.number(0, 15)),
        temperature_noise: i64::try_from(throws.number(0, 400)).unwrap_or(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faregate_planner::Problem;

    #[test]
    fn whatever_is_drawn_can_be_planned_and_is_drawn_again() {
        let mut followed = 0;
        for seed in 0..300 {
            let setup = Setup::random(seed);
            assert_eq!(setup.plan, Setup::random(seed).plan);
            let unfit = |plan: &Plan| Problem::new(plan, &setup.parameters, &setup.state).err();
            assert_eq!(unfit(&setup.plan), None, "seed {seed}");
            followed += u32::from(setup.next.is_some());
            if let Some(next) = &setup.next {
                assert_eq!(unfit(next), None, "seed {seed}");
            }
        }
        assert!((50..250).contains(&followed), "{followed}");
    }
}
