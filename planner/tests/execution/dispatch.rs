//! Slide "Control thread": constraints are checked again before a sequence is
//! started, because the state may have changed since it was scheduled.

use faregate_planner::execute::{Action, Event, NotReady};
use faregate_planner::plan::{Condition, Dependency, Outcome, StartRange, Status, Variable};
use faregate_planner::timed::Limit;
use faregate_planner::trace::{Unstarted, Why};
use faregate_planner::units::{Bytes, Span};
use faregate_planner::{Activity, ActivityId};

use crate::bench::{Bench, activity, asks, id, is_started, just_before, mandatory, min};

fn wants(actions: &[Action], why: Why) -> bool {
    actions.iter().any(|action| matches!(action, Action::Replan(all) if all.contains(&why)))
}

#[test]
fn a_sequence_is_dispatched_at_its_exact_time() {
    let mut bench = Bench::new(vec![(activity(1), 5)]);
    assert!(!asks(&bench.tick(just_before(min(5))), 1));
    assert_eq!(bench.control.due(), Some(min(5)));
    bench.starts(1, min(5));
    assert_eq!(bench.control.state().running[0].ends, min(15));
}

#[test]
fn acm_and_ddi_are_evaluated_only_then_and_an_unknown_one_is_not_satisfied() {
    for (kind, said) in [(Variable::Acm, "ACM may_drive"), (Variable::Ddi, "DDI may_drive")] {
        let conditions = vec![Condition { kind, name: "may_drive".into(), min: 1, max: 3 }];
        let mut bench = Bench::new(vec![(Activity { conditions, ..activity(1) }, 5)]);
        assert!(!asks(&bench.tick(min(5)), 1));
        let unknown = NotReady::Condition(said.into());
        assert_eq!(bench.control.waits_for(id(1)), Some(unknown.clone()));
        for (value, satisfied) in [(0, false), (4, false), (1, true)] {
            let actions = bench.event(min(6), Event::Variable("may_drive".into(), Some(value)));
            assert_eq!(asks(&actions, 1), satisfied, "{value}");
        }
        let actions = bench.event(min(6), Event::Variable("may_drive".into(), None));
        assert!(
            actions.contains(&Action::Withdraw(id(1))),
            "it is not right any more: {actions:?}"
        );
        assert_eq!(bench.control.waits_for(id(1)), Some(unknown));
    }
}

#[test]
fn an_activity_may_have_several_conditions_and_all_must_hold() {
    let condition =
        |name: &str| Condition { kind: Variable::Ddi, name: name.into(), min: 1, max: 1 };
    let conditions = vec![condition("stowed"), condition("level")];
    let mut bench = Bench::new(vec![(Activity { conditions, ..activity(1) }, 5)]);
    assert!(!asks(&bench.event(min(5), Event::Variable("level".into(), Some(1))), 1));
    assert!(asks(&bench.event(min(5), Event::Variable("stowed".into(), Some(1))), 1));
}

#[test]
fn the_planner_must_not_dispatch_unless_the_zone_is_ok_to_use() {
    let zones = vec!["mast".to_owned()];
    let mut bench = Bench::new(vec![(Activity { zones, ..activity(1) }, 5)]);
    bench.estimate(min(4), 80, false);
    let actions = bench.tick(min(5));
    assert!(!asks(&actions, 1));
    let heats = Action::Heat { zone: "mast".into(), on: true };
    assert!(actions.contains(&heats), "it is heated while it is waited for: {actions:?}");
    let actions = bench.tick(min(7));
    assert!(wants(&actions, Why::ZoneCold), "{actions:?}");
    assert_eq!(bench.control.state().cold, ["mast"]);
    assert!(asks(&bench.estimate(min(8), 80, true), 1));
    assert!(bench.control.state().cold.is_empty());
}

fn after(prior: ActivityId, statuses: &[Status]) -> Vec<Dependency> {
    vec![Dependency { prior, statuses: statuses.to_vec() }]
}

#[test]
fn a_dependency_is_held_against_what_really_became_of_the_prior_activity() {
    let on_success = Activity { after: after(id(1), &[Status::Succeeded]), ..activity(2) };
    let on_any = Activity { after: after(id(1), &[Status::Completed]), ..activity(3) };
    let mut bench = Bench::new(vec![(activity(1), 0), (on_success, 10), (on_any, 10)]);
    bench.starts(1, min(0));
    bench.ends(1, min(10), Outcome::Failed);
    let actions = bench.tick(min(10));
    assert!(!asks(&actions, 2));
    assert_eq!(bench.control.waits_for(id(2)), Some(NotReady::Dependency(id(1))));
    assert!(bench.control.state().ended.iter().any(|one| one.id == id(1)));
    assert_eq!(bench.control.waits_for(id(3)), None, "completed, though it failed");
}

#[test]
fn a_member_of_a_group_that_has_started_has_used_it_up() {
    let of_group = |number| Activity { group: Some("one".into()), ..activity(number) };
    let mut bench = Bench::new(vec![(of_group(1), 0), (of_group(2), 20)]);
    bench.starts(1, min(0));
    bench.ends(1, min(10), Outcome::Failed);
    bench.tick(min(20));
    assert_eq!(bench.control.waits_for(id(2)), Some(NotReady::Group(id(1))));
}

#[test]
fn a_start_that_would_break_the_soft_minimum_today_waits() {
    let hungry = Activity { marginal: crate::bench::watts(300), ..activity(1) };
    let mut bench = Bench::new(vec![(hungry, 5)]);
    bench.estimate(min(4), 41, true);
    assert!(!asks(&bench.tick(min(5)), 1));
    assert_eq!(bench.control.waits_for(id(1)), Some(NotReady::Limit(Limit::SoftMinimum)));
    assert!(asks(&bench.estimate(min(6), 99, true), 1));
}

#[test]
fn an_optional_start_that_would_make_too_much_data_waits_and_a_mandatory_one_does_not() {
    let data = Bytes::new(1_001);
    let much = Activity { data, ..activity(1) };
    let must = Activity { data, ..mandatory(2) };
    let mut bench = Bench::new(vec![(much, 5), (must, 5)]);
    let actions = bench.tick(min(5));
    assert_eq!([asks(&actions, 1), asks(&actions, 2)], [false, true]);
    assert_eq!(bench.control.waits_for(id(1)), Some(NotReady::Limit(Limit::Data)));
}

#[test]
fn a_start_that_is_late_for_want_of_tickets_is_pushed_within_its_range() {
    let mut bench = Bench::new(vec![(activity(1), 5)]);
    assert!(asks(&bench.tick(min(5)), 1));
    let actions = bench.tick(min(8));
    assert!(wants(&actions, Why::Late(id(1))), "{actions:?}");
    let pushed = bench.control.incumbent().slot(id(1)).expect("it is planned");
    assert_eq!((pushed.start, pushed.end), (min(8), min(18)));
    assert!(is_started(&bench.event(min(9), Event::Granted(id(1))), 1));
    assert_eq!(bench.control.state().running[0].ends, min(19));
}

#[test]
fn past_its_range_it_does_not_start_and_a_new_plan_is_wanted() {
    let mut bench = Bench::new(vec![(activity(1), 5)]);
    assert!(asks(&bench.tick(min(5)), 1));
    let closes = min(100).after(Span::from_secs(5));
    assert!(!bench.tick(closes).contains(&Action::Withdraw(id(1))), "the tolerance is not over");
    let actions = bench.tick(closes.after(Span::new(1)));
    assert!(actions.contains(&Action::Withdraw(id(1))), "{actions:?}");
    assert!(actions.contains(&Action::NotStarted(id(1), Unstarted::RangeClosed)));
    assert!(wants(&actions, Why::NotStarted(id(1))));
    assert_eq!(bench.outcome(1), Some(Outcome::NotStarted));
}

#[test]
fn a_start_within_the_tolerance_is_in_time_and_its_cutoff_is_not_moved() {
    let starts = vec![StartRange { from: min(5), to: min(5), cutoff: min(15) }];
    let tight = |number| Activity { starts: starts.clone(), ..activity(number) };
    let tolerated = min(5).after(Span::from_secs(5));
    let mut bench = Bench::new(vec![(tight(1), 5)]);
    assert!(asks(&bench.tick(min(5)), 1));
    assert!(is_started(&bench.event(tolerated, Event::Granted(id(1))), 1));
    assert_eq!(bench.control.state().running[0].cutoff, min(15));
    let mut bench = Bench::new(vec![(tight(1), 5)]);
    assert!(asks(&bench.tick(min(5)), 1));
    let late = bench.event(tolerated.after(Span::new(1)), Event::Granted(id(1)));
    assert!(!is_started(&late, 1), "a millisecond more is too late: {late:?}");
}

#[test]
fn a_vetoed_activity_does_not_start() {
    let mut bench = Bench::new(vec![(activity(1), 5)]);
    let actions = bench.event(min(1), Event::Veto(id(1)));
    assert!(actions.contains(&Action::NotStarted(id(1), Unstarted::Vetoed)));
    assert!(!asks(&bench.tick(min(5)), 1));
}

#[test]
fn everything_is_checked_once_more_when_the_tickets_come() {
    let zones = vec!["mast".to_owned()];
    let mut bench = Bench::new(vec![(Activity { zones, ..activity(1) }, 5)]);
    bench.estimate(min(4), 80, true);
    assert!(asks(&bench.tick(min(5)), 1));
    bench.estimate(min(6), 80, false);
    assert!(!is_started(&bench.event(min(6), Event::Granted(id(1))), 1));
    assert!(!bench.runs(1));
}
