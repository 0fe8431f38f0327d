use proptest::prelude::*;

use crate::derive::{Late, Placed, Placement, World};
use crate::problem::Problem;
use crate::schedule::Pass;
use crate::timeline::Intervals;
use crate::units::Time;

use super::small::small;
use super::{Effort, Stretch};

/// Whether a slot keeps the limits that depend on what is derived: everything
/// from nothing, looked at millisecond by millisecond.
fn fits(pass: &Pass<'_>, slot: Placement, optional: bool) -> bool {
    let problem = pass.problem;
    let without = &pass.world;
    let mut placed = pass.placed.clone();
    placed.insert(problem, slot);
    let with = World::of(problem, &placed);
    let blocked = |block: &crate::problem::Block| {
        let touches = |from: i64, to: i64| from < block.to && block.from < to && from < to;
        let heats = placed.zones.iter().flat_map(|zone| zone.heats.iter().flatten());
        let mut own = heats.filter(|heat| heat.item == slot.item);
        touches(slot.start, slot.end) || own.any(|heat| touches(heat.from, heat.to))
    };
    let late = |late: &Late| !without.has(*late);
    if problem.blocks.iter().any(blocked) || with.late.iter().any(late) {
        return false;
    }
    let battery = &problem.battery;
    let low = |at: i64| with.charge(at) < battery.soft && with.charge(at) < without.charge(at);
    let peak = |world: &World, at: i64| world.pieces[world.at(at)].peak;
    let high =
        |at: i64| peak(&with, at) > problem.peak_limit && peak(&with, at) > peak(without, at);
    let handover = problem.handover.filter(|_| optional).is_some_and(|at| {
        with.charge(at) < battery.handover && with.charge(at) < without.charge(at)
    });
    !handover && !(problem.now..=problem.end).any(|at| low(at) || high(at))
}

fn tries_every_start(pass: &Pass<'_>, item: usize, optional: bool) -> Result<(), TestCaseError> {
    let problem = pass.problem;
    let length = problem.items[item].shortest;
    let (first, last) = (problem.now, problem.end - length);
    let all = Intervals::between(Time::new(first), Time::new(last));
    let mut effort = Effort::default();
    let found = pass.rest().earliest(item, &all, optional, &mut effort);
    let slot = |start| Placement { item, start, end: start + length };
    let tried = (first..=last).find(|&start| fits(pass, slot(start), optional));
    prop_assert_eq!(found, tried, "item {}, optional {}", item, optional);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    /// The earliest start is what trying every millisecond finds, for each
    /// candidate beside what is placed before it.
    #[test]
    fn the_earliest_start_is_exact((plan, parameters, state) in small()) {
        let problem = Problem::new(&plan, &parameters, &state);
        prop_assert!(problem.is_ok(), "{:?}", problem.err());
        let problem = problem.unwrap();
        let mut pass = Pass::new(&problem, None);
        for &item in problem.order() {
            tries_every_start(&pass, item, true)?;
            tries_every_start(&pass, item, false)?;
            pass.turn(item);
        }
    }

    /// With hardly any patience what is found keeps every limit all the same, is
    /// no earlier than the earliest, and costs no more than there was patience
    /// for, twice over, and one start for each stretch.
    #[test]
    fn without_patience_what_is_found_still_fits((plan, parameters, state) in small()) {
        let problem = Problem::new(&plan, &parameters, &state).unwrap();
        let mut pass = Pass::new(&problem, None);
        for &item in problem.order() {
            let length = problem.items[item].shortest;
            let (first, last) = (Time::new(problem.now), Time::new(problem.end - length));
            let starts = &Intervals::between(first, last);
            let (mut quick, mut exact) = (Effort::default(), Effort::default());
            let stretch = Stretch { item, starts, optional: true, patience: 2 };
            let found = pass.rest().earliest_of(stretch, &mut quick);
            let earliest = pass.rest().earliest(item, starts, true, &mut exact);
            if let Some(start) = found {
                let slot = Placement { item, start, end: start + length };
                prop_assert!(fits(&pass, slot, true));
                prop_assert!(earliest.is_some_and(|earliest| earliest <= start));
            }
            prop_assert!(quick.starts <= 12, "{} starts", quick.starts);
            pass.turn(item);
        }
    }

    /// What is kept while activities are placed one after the other is what
    /// follows from all of them at once.
    #[test]
    fn kept_and_derived_from_nothing_are_equal((plan, parameters, state) in small()) {
        let problem = Problem::new(&plan, &parameters, &state).unwrap();
        let mut pass = Pass::new(&problem, None);
        for &item in problem.order() {
            pass.turn(item);
            let slots = pass.slots.iter().enumerate();
            let slots = slots.filter(|(at, _)| problem.items[*at].is_candidate());
            let slots: Vec<Placement> = slots.filter_map(|(item, slot)| slot.map(|slot| {
                Placement { item, start: slot.start.get(), end: slot.end.get() }
            })).collect();
            let full = Placed::full(&problem, &slots);
            prop_assert_eq!(&pass.placed, &full);
            prop_assert_eq!(&pass.world, &World::of(&problem, &full));
        }
    }
}
