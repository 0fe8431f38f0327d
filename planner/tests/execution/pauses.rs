//! Slide "More implementation": pause and resume.

use faregate_planner::Activity;
use faregate_planner::execute::{Action, Event};
use faregate_planner::trace::Cause;

use crate::bench::{Bench, activity, id, just_before, min};

fn pausable() -> Activity {
    Activity { pausable: true, ..activity(1) }
}

#[test]
fn a_pausable_activity_is_paused_when_its_tickets_are_taken() {
    let mut bench = Bench::new(vec![(pausable(), 0)]);
    bench.starts(1, min(0));
    assert!(bench.event(min(4), Event::Taken(id(1))).contains(&Action::Pause(id(1))));
    assert!(bench.runs(1));
    assert!(bench.event(min(9), Event::Returned(id(1))).contains(&Action::Resume(id(1))));
    assert_eq!(bench.control.state().running[0].ends, min(15), "later by the time of its pause");
}

#[test]
fn the_time_of_a_pause_is_not_counted_as_duration() {
    let mut bench = Bench::new(vec![(pausable(), 0)]);
    bench.starts(1, min(0));
    bench.event(min(4), Event::Taken(id(1)));
    bench.tick(min(30));
    assert!(bench.runs(1), "past its duration, and paused");
    bench.event(min(40), Event::Returned(id(1)));
    bench.tick(just_before(min(46)));
    assert!(bench.runs(1));
    let over = Action::Abort(id(1), Cause::Duration);
    assert!(bench.tick(min(46)).contains(&over));
}

#[test]
fn the_cutoff_runs_on_while_it_is_paused() {
    let mut bench = Bench::new(vec![(pausable(), 0)]);
    bench.starts(1, min(0));
    bench.event(min(4), Event::Taken(id(1)));
    let actions = bench.tick(min(200));
    assert!(actions.contains(&Action::Abort(id(1), Cause::Cutoff)), "{actions:?}");
}

#[test]
fn what_cannot_be_paused_is_aborted_when_its_tickets_are_taken() {
    let mut bench = Bench::new(vec![(activity(1), 0)]);
    bench.starts(1, min(0));
    let actions = bench.event(min(4), Event::Taken(id(1)));
    assert!(actions.contains(&Action::Abort(id(1), Cause::TicketsTaken)), "{actions:?}");
}

#[test]
fn a_paused_activity_draws_nothing_that_a_limit_could_abort() {
    let mut bench = Bench::new(vec![(pausable(), 0)]);
    bench.starts(1, min(0));
    bench.event(min(4), Event::Taken(id(1)));
    bench.estimate(min(5), 10, true);
    assert!(bench.runs(1));
}
