//! Data that was exchanged in communication windows that are over.

use faregate_planner::generate::{Shape, World};
use faregate_planner::state::Window;
use faregate_planner::units::{Bytes, Span};
use faregate_planner::{Problem, TimedPlan, project, schedule};

/// A relay of ten minutes that ended an hour before the present.
fn relay(world: &World, data: i64) -> Window {
    let end = world.state.now.before(Span::from_mins(60));
    Window {
        name: "relay".into(),
        start: end.before(Span::from_mins(10)),
        end,
        awake: true,
        marginal: Default::default(),
        peak: Default::default(),
        data: Bytes::new(data),
        engines: 1,
        resources: Default::default(),
    }
}

fn planned(world: &World) -> TimedPlan {
    let problem = Problem::new(&world.plan, &world.parameters, &world.state);
    schedule(&problem.expect("a drawn world is fit"), None)
}

const MB: i64 = 1_000_000;

#[test]
fn a_plan_after_a_relay_is_the_plan_with_that_data_gone() {
    let mut otherwise = 0;
    for seed in 0..20 {
        for sent in [-60 * MB, 45 * MB] {
            let mut world = Shape::small(30, seed).draw();
            world.plan.max_delta_data = Bytes::new(90 * MB);
            let mut after = world.clone();
            after.state.windows.insert(0, relay(&world, sent));
            let mut gone = world.clone();
            gone.plan.max_delta_data = Bytes::new(world.plan.max_delta_data.get() - sent);
            assert_eq!(planned(&after), planned(&gone), "seed {seed}, {sent} B");
            otherwise += u32::from(planned(&after) != planned(&world));
        }
    }
    assert!(otherwise >= 10, "it matters in {otherwise} of 40");
}

#[test]
fn the_projection_of_data_begins_with_what_was_sent() {
    let mut world = Shape::small(20, 3).draw();
    let timed = planned(&world);
    let data = |world: &World| {
        let projected = project(&world.plan, &world.parameters, &world.state, &timed);
        let lines = projected.expect("its timelines are known").lines;
        lines.into_iter().find(|line| line.name == "data").expect("data is a line").points
    };
    let before = data(&world);
    world.state.windows.insert(0, relay(&world, -7 * MB));
    let after = data(&world);
    let less: Vec<_> = before.iter().map(|(at, value)| (*at, value - 7 * MB)).collect();
    assert_eq!(after, less);
}

#[test]
fn a_window_that_nobody_lists_any_more_stays_if_it_is_over() {
    let mut world = Shape::small(5, 1).draw();
    let (over, now) = (relay(&world, -MB), world.state.now);
    let coming = Window {
        name: "next".into(),
        start: now.after(Span::new(1)),
        end: now.after(Span::new(9)),
        ..over.clone()
    };
    let corrected = Window { data: Bytes::new(-3 * MB), ..over.clone() };
    let state = &mut world.state;
    state.windows = vec![over.clone(), coming.clone()];
    state.queried(vec![coming.clone()]);
    assert_eq!(state.windows, [over, coming.clone()], "what has taken place has taken place");
    state.queried(vec![corrected.clone(), coming]);
    assert_eq!(state.windows[0], corrected, "and what was really sent can be told later");
    assert_eq!(state.exchanged(), i128::from(-3 * MB));
    state.queried(Vec::new());
    assert_eq!(state.windows, [corrected], "a window that has not ended can be called off");
}
