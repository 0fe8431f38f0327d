//! A gauge that is silent: the control thread sees estimates alone, and one that
//! is too old is none.

use faregate_planner::execute::{Action, Event, Options};
use faregate_planner::state::Mode;
use faregate_planner::trace::Cause;
use faregate_planner::units::{Span, Time};
use faregate_tickets::amount::Milliwatts;

use crate::bench::{Bench, activity, asks, id, just_before, min, parameters};

/// Estimates hold for ten minutes.
const HOLDS: Span = Span::from_mins(10);

fn bench() -> Bench {
    let idle = |number| {
        let idle = crate::bench::mandatory(number);
        faregate_planner::Activity {
            marginal: Milliwatts::ZERO,
            duration: Span::from_mins(60),
            ..idle
        }
    };
    let long = faregate_planner::Activity { duration: Span::from_mins(60), ..activity(1) };
    let options = Options { charge_holds: HOLDS, ..Options::default() };
    let mut bench = Bench::with(
        vec![(long, 2), (idle(2), 2), (activity(3), 20)],
        parameters(),
        options,
        |_, _| (),
    );
    bench.estimate(min(2), 80, true);
    bench.starts(1, min(2));
    bench.starts(2, min(2));
    bench
}

/// When nobody knows the charge any more.
const BLIND: Time = min(12);

fn unknown(actions: &[Action]) -> Vec<u32> {
    let aborted = actions.iter().filter_map(|action| match action {
        Action::Abort(id, Cause::ChargeUnknown) => Some(id.get()),
        _ => None,
    });
    aborted.collect()
}

#[test]
fn what_draws_is_aborted_to_the_millisecond_and_what_does_not_goes_on() {
    let mut bench = bench();
    assert_eq!(unknown(&bench.tick(just_before(BLIND))), [0; 0]);
    assert!(bench.control.due().is_some_and(|at| at <= BLIND), "it comes in time");
    assert_eq!(unknown(&bench.tick(BLIND)), [1]);
    assert!(bench.runs(2));
}

#[test]
fn an_estimate_in_time_lets_everything_go_on() {
    let mut bench = bench();
    bench.estimate(just_before(BLIND), 80, true);
    assert_eq!(unknown(&bench.tick(BLIND)), [0; 0]);
    assert!(bench.runs(1));
}

#[test]
fn nothing_starts_while_nobody_knows_the_charge() {
    let mut bench = bench();
    bench.tick(BLIND);
    assert!(!asks(&bench.tick(min(20)), 3));
    assert!(asks(&bench.estimate(min(21), 80, true), 3));
}

#[test]
fn when_nothing_runs_any_more_the_computer_sleeps_and_looks_again_later() {
    let mut bench = bench();
    bench.tick(BLIND);
    let actions = bench.event(min(13), Event::Stop(id(2)));
    assert!(actions.iter().any(|action| matches!(action, Action::ShutDown(_))), "{actions:?}");
    bench.event(min(18), Event::Mode(Mode::Asleep));
    let wakes = |actions: &[Action]| actions.iter().any(|one| matches!(one, Action::Wake(_)));
    assert!(!wakes(&bench.tick(min(30))), "the phase that was planned began before");
}

#[test]
fn who_has_come_up_plans_with_what_it_finds() {
    let mut bench = bench();
    bench.event(min(3), Event::Mode(Mode::Asleep));
    let plans = |actions: &[Action]| actions.iter().any(|one| matches!(one, Action::Replan(_)));
    assert!(!plans(&bench.event(min(4), Event::Mode(Mode::Awake))));
    assert!(plans(&bench.estimate(min(4), 70, true)));
}
