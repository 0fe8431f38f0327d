//! Slide "Plan file": handover time and next plan filename.

use std::sync::Arc;

use faregate_planner::Plan;
use faregate_planner::execute::{Action, Event};
use faregate_planner::trace::Unstarted;

use crate::bench::{Bench, END, activity, asks, id, min, options, parameters};

fn before_handover() -> Bench {
    let hands_over = |plan: &mut Plan, _: &mut _| {
        plan.handover = min(60);
        plan.next_plan = Some("next".into());
    };
    let mut first = activity(1);
    first.duration = faregate_planner::units::Span::from_mins(30);
    let activities = vec![(first, 50), (activity(2), 90)];
    let mut bench = Bench::with(activities, parameters(), options(), hands_over);
    bench.starts(1, min(50));
    bench
}

fn next(number: u32) -> Arc<Plan> {
    let end = min(2 * END);
    Arc::new(Plan { handover: end, end, activities: vec![activity(number)], ..Plan::default() })
}

#[test]
fn the_next_plan_takes_over_and_what_runs_stays_with_its_own_cutoff() {
    let mut bench = before_handover();
    assert!(bench.tick(min(60)).contains(&Action::LoadNext("next".into())));
    let actions = bench.event(min(60), Event::Next(Ok(next(7))));
    assert!(actions.contains(&Action::HandedOver), "{actions:?}");
    assert!(actions.contains(&Action::NotStarted(id(2), Unstarted::HandedOver)));
    assert!(bench.runs(1));
    assert_eq!(bench.control.state().running[0].cutoff, min(200));
    let ids: Vec<_> = bench.control.plan().activities.iter().map(|one| one.id).collect();
    assert_eq!(ids, [id(7), id(1)]);
    assert!(!asks(&bench.tick(min(90)), 2), "it was dropped");
}

#[test]
fn without_a_next_plan_this_one_goes_on_to_its_end() {
    let mut bench = before_handover();
    bench.tick(min(60));
    let actions = bench.event(min(60), Event::Next(Err("it is damaged".into())));
    assert!(actions.contains(&Action::NoNextPlan("it is damaged".into())), "{actions:?}");
    assert!(asks(&bench.tick(min(90)), 2));
    bench.tick(min(END));
    assert!(bench.control.is_over());
    assert_eq!(bench.control.due(), None);
}

#[test]
fn a_next_plan_that_uses_the_number_of_what_runs_is_refused() {
    let mut bench = before_handover();
    bench.tick(min(60));
    let actions = bench.event(min(60), Event::Next(Ok(next(1))));
    assert!(actions.iter().any(|action| matches!(action, Action::NoNextPlan(_))), "{actions:?}");
}

#[test]
fn a_next_plan_that_is_over_is_refused() {
    let mut bench = before_handover();
    bench.tick(min(60));
    let over = Plan { end: min(60), ..Plan::clone(&next(7)) };
    let actions = bench.event(min(60), Event::Next(Ok(Arc::new(over))));
    assert!(actions.iter().any(|action| matches!(action, Action::NoNextPlan(_))), "{actions:?}");
}

#[test]
fn a_next_plan_that_is_to_be_handed_over_itself_is_refused() {
    let mut bench = before_handover();
    bench.tick(min(60));
    let handed_over =
        Plan { handover: min(60), next_plan: Some("itself".into()), ..Plan::clone(&next(7)) };
    let actions = bench.event(min(60), Event::Next(Ok(Arc::new(handed_over))));
    assert!(actions.iter().any(|action| matches!(action, Action::NoNextPlan(_))), "{actions:?}");
}
