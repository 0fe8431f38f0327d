//! Slides "Goals" and "The schedule is generated at a lower rate": when a new
//! plan is made.

use faregate_planner::TimedPlan;
use faregate_planner::execute::{Action, Event, Options};
use faregate_planner::state::Mode;
use faregate_planner::trace::Why;
use faregate_planner::units::Span;

use crate::bench::{Bench, activity, just_before, min, options, parameters};

fn wants(actions: &[Action], why: Why) -> bool {
    actions.iter().any(|action| matches!(action, Action::Replan(all) if all.contains(&why)))
}

#[test]
fn once_a_period_also_when_nothing_happens() {
    let options = Options { period: Span::from_mins(30), ..options() };
    let mut bench = Bench::with(Vec::new(), parameters(), options, |_, _| ());
    assert!(!wants(&bench.tick(just_before(min(30))), Why::Periodic));
    assert_eq!(bench.control.due(), Some(min(30)), "it comes by itself");
    assert!(wants(&bench.tick(min(30)), Why::Periodic));
    assert!(!wants(&bench.tick(min(59)), Why::Periodic));
    assert!(wants(&bench.tick(min(60)), Why::Periodic));
}

#[test]
fn when_the_communication_windows_change() {
    let mut bench = Bench::new(vec![(activity(1), 5)]);
    assert!(wants(&bench.event(min(1), Event::Windows(Vec::new())), Why::Windows));
}

#[test]
fn nobody_plans_in_a_sleep_and_what_came_up_meanwhile_is_planned_for_after_it() {
    let sleeps = |_: &mut _, timed: &mut TimedPlan| {
        let phase = &mut timed.awake[0];
        (phase.wakeup, phase.up) = (min(25), min(30));
    };
    let mut bench = Bench::with(Vec::new(), parameters(), options(), sleeps);
    bench.event(min(1), Event::Mode(Mode::Asleep));
    let is_plan = |action: &Action| matches!(action, Action::Replan(_));
    assert!(!bench.event(min(2), Event::Windows(Vec::new())).iter().any(is_plan));
    bench.event(min(30), Event::Mode(Mode::Awake));
    assert!(wants(&bench.estimate(min(30), 80, true), Why::Windows));
}
