//! Drawn worlds are what they are said to be.

use std::collections::BTreeSet;

use faregate_planner::generate::Shape;
use faregate_planner::plan::Kind;
use faregate_planner::timed::{Fate, Limit, Reason};
use faregate_planner::units::Time;
use faregate_planner::{Activity, Problem, schedule};

#[test]
fn equal_seeds_draw_equal_worlds() {
    for shape in [Shape::sols(150, 4), Shape::small(40, 4)] {
        assert_eq!(shape.draw(), shape.draw());
        let other = Shape { seed: 5, ..shape };
        assert_ne!(shape.draw().plan.activities, other.draw().plan.activities);
    }
}

#[test]
fn a_world_of_sols_has_everything() {
    let world = Shape::sols(400, 1).draw();
    let activities = &world.plan.activities;
    assert_eq!(activities.len(), 400);
    let kinds: BTreeSet<_> = activities
        .iter()
        .map(|one| match one.kind {
            Kind::Generic => "generic",
            Kind::Expanding { .. } => "expanding",
            Kind::StayAwake => "stay awake",
            Kind::Cleanup => "cleanup",
            Kind::ManualShutdown { .. } => "manual",
        })
        .collect();
    let wanted = ["generic", "expanding", "stay awake", "cleanup"];
    assert!(wanted.iter().all(|kind| kinds.contains(kind)), "{kinds:?}");
    assert!(activities.iter().any(|one| one.group.is_some()));
    assert!(activities.iter().any(|one| one.zones.len() == 2));
    assert!(activities.iter().any(|one| !one.after.is_empty()));
    assert!(activities.iter().any(|one| !one.impacts.is_empty()));
    assert!(activities.iter().any(|one| one.priority >= world.parameters.mandatory_from));
    assert!(Problem::new(&world.plan, &world.parameters, &world.state).is_ok());
}

#[test]
fn a_crowded_sol_leaves_something_out_for_its_charge() {
    let world = Shape { per_sol: Some(60), draw: 200, ..Shape::sols(60, 1) }.draw();
    let problem = Problem::new(&world.plan, &world.parameters, &world.state).expect("it is fit");
    let timed = schedule(&problem, None);
    let charge = |fate: &Fate| {
        let Fate::Out(Reason::Limit { limit, .. }) = fate else { return false };
        matches!(limit, Limit::SoftMinimum | Limit::Handover)
    };
    let kept_out = timed.rows.iter().filter(|row| charge(&row.fate)).count();
    assert!(kept_out >= 10, "{kept_out} of 60: {:?}", timed.rows);
    assert!(!timed.awake.is_empty() && !timed.preheats.is_empty());
}

#[test]
fn a_small_world_lies_on_its_grid_and_so_do_its_plans() {
    let world = Shape::small(60, 9).draw();
    let on_grid = |at: Time| at.get() % 600_000 == 0;
    for one in &world.plan.activities {
        assert!(on_grid(Time::ZERO.after(one.duration)));
        assert!(one.starts.iter().all(|range| range.from == range.to && on_grid(range.from)));
        assert!(one.starts.iter().all(|range| range.cutoff == range.to.after(one.duration)));
    }
    let problem = Problem::new(&world.plan, &world.parameters, &world.state).expect("it is fit");
    let timed = schedule(&problem, None);
    let out = timed.rows.iter().filter(|row| matches!(row.fate, Fate::Out(_))).count();
    assert!((6..60).contains(&out), "more than fit: {out} are left out");
    assert!(timed.unavoidable.is_empty(), "alone it keeps its limits");
    let phases = timed.awake.iter().flat_map(|up| [up.wakeup, up.up, up.down, up.asleep]);
    let heats = timed.preheats.iter().flat_map(|heat| [heat.start, heat.end]);
    assert!(phases.chain(heats).all(on_grid));
}

#[test]
fn a_small_world_has_what_an_exact_solver_can_model() {
    let world = Shape::small(60, 9).draw();
    let any = |holds: fn(&Activity) -> bool| world.plan.activities.iter().any(holds);
    assert!(any(|one| !one.zones.is_empty()));
    assert!(any(|one| !one.after.is_empty()) && any(|one| one.group.is_some()));
    let from = world.parameters.mandatory_from;
    assert!(world.plan.activities.iter().any(|one| one.priority >= from));
    assert!(any(|one| one.kind == Kind::Generic) && !any(|one| one.kind != Kind::Generic));
    assert!(!world.state.windows.is_empty() && world.plan.handover < world.plan.end);
}
