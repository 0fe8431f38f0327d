//! Drawn worlds are what they are said to be.

use std::collections::BTreeSet;

use faregate_planner::generate::Shape;
use faregate_planner::plan::Kind;
use faregate_planner::timed::{Fate, Limit, Reason};
use faregate_planner::{Problem, schedule};

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
fn a_small_world_lies_on_its_grid() {
    let world = Shape::small(60, 9).draw();
    let on_grid = |ms: i64| ms % 300_000 == 0;
    for one in &world.plan.activities {
        assert!(on_grid(one.duration.get()) && one.zones.is_empty() && one.after.is_empty());
        assert!(one.starts.iter().all(|range| {
            on_grid(range.from.get()) && on_grid(range.to.get()) && on_grid(range.cutoff.get())
        }));
        assert!(one.priority < world.parameters.mandatory_from);
    }
    let problem = Problem::new(&world.plan, &world.parameters, &world.state).expect("it is fit");
    let timed = schedule(&problem, None);
    let out = timed.rows.iter().filter(|row| matches!(row.fate, Fate::Out(_))).count();
    assert!((6..60).contains(&out), "more than fit: {out} are left out");
    assert!(timed.unavoidable.is_empty(), "alone it keeps its limits");
}
