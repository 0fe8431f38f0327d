//! What is kept from one candidate to the next is what follows from nothing:
//! over sols, with heating, windows and expanding activities, plans come out the
//! same to the byte as where each start is judged by a world of its own.

use faregate_planner::generate::{Shape, World};
use faregate_planner::timed::{Fate, TimedPlan};
use faregate_planner::{Problem, schedule, schedule_plainly};
use faregate_tickets::amount::Microjoules;

fn problem(world: &World) -> Problem {
    let problem = Problem::new(&world.plan, &world.parameters, &world.state);
    problem.unwrap_or_else(|unfit| panic!("unfit: {unfit:?}"))
}

/// Sparse worlds, in which nights pass the maximum, and crowded ones, in which
/// the charge keeps much out.
fn worlds() -> impl Iterator<Item = (Shape, World)> {
    let shapes = (0..12_u64).map(|seed| {
        let (per_sol, draw) = [(45, 100), (60, 60), (60, 100), (90, 100)][(seed % 4) as usize];
        Shape { per_sol: Some(per_sol), draw, ..Shape::sols(90, seed) }
    });
    let crowded = (0..8_u64).map(|seed| Shape { draw: 200, ..Shape::sols(60, seed) });
    let small = (0..4).map(|seed| Shape::small(40, seed));
    shapes.chain(crowded).chain(small).map(|shape| (shape, shape.draw()))
}

fn bytes(timed: &TimedPlan) -> String {
    serde_json::to_string(timed).expect("a plan can be written")
}

#[test]
fn kept_worlds_plan_what_worlds_from_nothing_plan() {
    let (mut longer, mut out) = (0, 0);
    for (shape, world) in worlds() {
        let problem = problem(&world);
        let (plain, _) = schedule_plainly(&problem);
        assert_eq!(bytes(&schedule(&problem, None)), bytes(&plain), "{shape:?}");
        for (row, one) in plain.rows.iter().zip(&world.plan.activities) {
            match row.fate {
                Fate::Scheduled(slot) => longer += u32::from(slot.length() > one.placed()),
                _ => out += 1,
            }
        }
    }
    assert!(longer > 20 && out > 200, "a weak test: {longer} made longer, {out} left out");
}

/// The comparison sees a difference of a few milliseconds, or of one reason.
#[test]
fn with_a_little_less_charge_the_plans_differ() {
    let differing = worlds().filter(|(_, world)| {
        let mut less = world.clone();
        less.state.charge = Microjoules::new(less.state.charge.get() - 1_000_000);
        let (plain, _) = schedule_plainly(&problem(&less));
        bytes(&schedule(&problem(world), None)) != bytes(&plain)
    });
    assert!(differing.count() > 5);
}
