//! Attempts to make the control thread start what it must not, or let it run on.

use std::sync::Arc;

use faregate_agents::Categories;
use faregate_planner::execute::{Action, Event, NotReady, Options};
use faregate_planner::plan::{Kind, Outcome, StartRange};
use faregate_planner::state::{Mode, Window};
use faregate_planner::timed::Limit;
use faregate_planner::trace::Cause;
use faregate_planner::units::{Bytes, Ppm, Span};
use faregate_planner::{Activity, Parameters, Plan};
use faregate_tickets::amount::Milliwatts;

use crate::bench::{
    Bench, END, activity, asks, id, just_before, mandatory, min, options, parameters, watts,
};

fn waits_for(bench: &Bench, number: u32) -> Option<NotReady> {
    bench.control.waits_for(id(number))
}

#[test]
fn nothing_starts_while_the_computer_is_not_up() {
    for mode in [Mode::Asleep, Mode::WakingUp, Mode::ShuttingDown] {
        let mut bench = Bench::new(vec![(activity(1), 5)]);
        bench.event(min(1), Event::Mode(mode));
        assert!(!asks(&bench.tick(min(5)), 1));
        assert_eq!(waits_for(&bench, 1), Some(NotReady::Computer), "{mode:?}");
    }
}

#[test]
fn a_member_of_a_group_that_was_vetoed_has_not_used_it_up() {
    let of_group = |number| Activity { group: Some("one".into()), ..activity(number) };
    let mut bench = Bench::new(vec![(of_group(1), 10), (of_group(2), 20)]);
    bench.event(min(1), Event::Veto(id(1)));
    assert_eq!(bench.outcome(1), Some(Outcome::NotStarted));
    bench.starts(2, min(20));
}

/// By its tolerance, and not by a millisecond more: its start and its end.
#[test]
fn a_start_is_late_by_the_tolerance_at_most() {
    let tolerance = parameters().handover_tolerance;
    let with = |to, cutoff| {
        let starts = vec![StartRange { from: min(0), to: min(to), cutoff: min(cutoff) }];
        let mut bench = Bench::new(vec![(Activity { starts, ..mandatory(1) }, 5)]);
        assert!(asks(&bench.tick(min(5)), 1), "it asks for its tickets, and gets none");
        bench
    };
    for (to, cutoff, last) in [(20, 200, 20), (100, 30, 20)] {
        let last = min(last).after(tolerance);
        let mut bench = with(to, cutoff);
        bench.tick(last);
        assert_eq!(waits_for(&bench, 1), None, "range to {to}, cutoff {cutoff}");
        let late = last.after(Span::new(1));
        bench.tick(late);
        bench.event(late, Event::Granted(id(1)));
        assert!(!bench.runs(1), "range to {to}, cutoff {cutoff}");
    }
}

/// It has another range, and so it is not given up.
#[test]
fn between_two_ranges_nothing_starts() {
    let range = |from, to| StartRange { from: min(from), to: min(to), cutoff: min(200) };
    let starts = vec![range(0, 20), range(60, 80)];
    let mut bench = Bench::new(vec![(Activity { starts, ..mandatory(1) }, 5)]);
    let last = min(20).after(parameters().handover_tolerance);
    bench.tick(last);
    assert_eq!(waits_for(&bench, 1), None);
    for at in [last.after(Span::new(1)), just_before(min(60))] {
        bench.tick(at);
        assert_eq!(waits_for(&bench, 1), Some(NotReady::Range), "at {at}");
        bench.event(at, Event::Granted(id(1)));
        assert!(!bench.runs(1));
    }
    bench.starts(1, min(60));
}

/// Nothing that is planned moves for it.
#[test]
fn a_late_drive_ends_when_it_was_planned_to() {
    let kind = Kind::Expanding { minimum: Span::from_mins(4) };
    let drive = || Activity { kind, ..mandatory(1) };
    for (granted, ends) in [(5, 15), (9, 15), (13, 17)] {
        let mut bench = Bench::new(vec![(drive(), 5)]);
        bench.tick(min(5));
        bench.event(min(granted), Event::Granted(id(1)));
        assert_eq!(bench.control.state().running[0].ends, min(ends), "granted at {granted}");
    }
}

/// The plan hands over right after it, with this charge or more.
fn before_handover(one: Activity, percent: i64) -> Bench {
    Bench::with(vec![(one, 5)], parameters(), options(), |plan, _| {
        plan.handover = min(16);
        plan.handover_min_soc = Ppm::new(percent * 10_000);
    })
}

#[test]
fn an_optional_start_that_would_leave_too_little_at_handover_waits() {
    let mut bench = before_handover(activity(1), 80);
    assert!(!asks(&bench.tick(min(5)), 1));
    assert_eq!(waits_for(&bench, 1), Some(NotReady::Limit(Limit::Handover)));
    assert!(asks(&before_handover(mandatory(1), 80).tick(min(5)), 1));
    assert!(asks(&before_handover(activity(1), 70).tick(min(5)), 1));
}

/// Nobody has charge enough for anything, and it takes nothing.
#[test]
fn a_start_that_makes_nothing_worse_does_not_wait() {
    let of = |marginal| {
        let mut bench = Bench::new(vec![(Activity { marginal, ..mandatory(1) }, 5)]);
        bench.estimate(min(4), 30, true);
        asks(&bench.tick(min(5)), 1)
    };
    assert!(of(Milliwatts::ZERO));
    assert!(!of(Milliwatts::new(1)));
}

#[test]
fn data_that_are_being_sent_are_on_board_until_they_are_sent() {
    let pass = Window {
        name: "pass".into(),
        start: min(2),
        end: min(9),
        awake: true,
        marginal: watts(1),
        peak: watts(1),
        data: Bytes::new(-500),
        engines: 0,
        resources: Categories::NONE,
    };
    let mut bench = Bench::new(vec![(Activity { data: Bytes::new(1_001), ..activity(1) }, 5)]);
    bench.event(min(1), Event::Windows(vec![pass]));
    assert!(!asks(&bench.tick(min(5)), 1));
    assert_eq!(waits_for(&bench, 1), Some(NotReady::Limit(Limit::Data)));
    assert!(!asks(&bench.tick(just_before(min(9))), 1));
    assert!(asks(&bench.tick(min(9)), 1));
}

#[test]
fn two_that_have_more_engines_than_a_number_counts_do_not_start_together() {
    let engines = 3_000_000_000;
    let with = |number, at| (Activity { engines, ..activity(number) }, at);
    let some = vec![(activity(1), 0), with(2, 30), with(3, 50)];
    let parameters = Parameters { engines: u32::MAX, ..parameters() };
    let mut bench = Bench::with(some, parameters, options(), |_, _| ());
    bench.starts(1, min(0));
    let actions = bench.ends(1, min(4), Outcome::Succeeded);
    assert_eq!([asks(&actions, 2), asks(&actions, 3)], [true, false]);
}

/// The next plan is over before the cutoff of what runs.
#[test]
fn what_runs_at_handover_ends_with_the_plan_that_took_over() {
    let long = Activity { duration: Span::from_mins(150), ..mandatory(1) };
    let mut bench = Bench::with(vec![(long, 5)], parameters(), options(), |plan, _| {
        plan.handover = min(60);
        plan.next_plan = Some("next".into());
    });
    bench.starts(1, min(5));
    bench.tick(min(60));
    let next = Plan { handover: min(90), end: min(90), ..Plan::default() };
    bench.event(min(60), Event::Next(Ok(Arc::new(next))));
    bench.tick(just_before(min(90)));
    assert!(bench.runs(1));
    assert!(bench.tick(min(90)).contains(&Action::Abort(id(1), Cause::Cutoff)));
    assert!(bench.control.is_over());
}

/// Whatever happens afterwards.
#[test]
fn what_was_aborted_does_not_start_again() {
    let mut bench = Bench::new(vec![(Activity { pausable: true, ..activity(1) }, 0)]);
    bench.starts(1, min(0));
    bench.event(min(1), Event::Stop(id(1)));
    let timed = bench.control.timed().clone();
    bench.event(min(2), Event::Returned(id(1)));
    bench.event(min(2), Event::Granted(id(1)));
    bench.event(min(2), Event::Ended(id(1), Outcome::Succeeded, Bytes::ZERO));
    assert!(!asks(&bench.event(min(2), Event::Adopt(Box::new(timed))), 1));
    assert!(!asks(&bench.tick(min(3)), 1));
    assert!(!bench.runs(1));
    assert_eq!(bench.outcome(1), Some(Outcome::Aborted));
    let times = bench.control.state().ended.iter().filter(|one| one.id == id(1)).count();
    assert_eq!(times, 1);
}

/// Nobody asked for them any more, or ever.
#[test]
fn tickets_that_come_unasked_start_nothing() {
    let mut bench = Bench::new(vec![(activity(1), 5), (activity(2), 20)]);
    bench.event(min(4), Event::Granted(id(1)));
    assert!(!bench.runs(1));
    bench.starts(1, min(5));
    bench.event(min(6), Event::Granted(id(1)));
    assert_eq!(bench.control.state().running.len(), 1);
    bench.tick(min(20));
    bench.event(min(20), Event::Adopt(Box::default()));
    bench.event(min(20), Event::Granted(id(2)));
    assert!(!bench.runs(2), "a plan without it has come in between");
}

/// After the plan's end there is nothing that could start.
#[test]
fn nothing_starts_at_the_plans_end() {
    let starts = vec![StartRange { from: min(0), to: min(2 * END), cutoff: min(2 * END) }];
    let late = Activity { starts, ..mandatory(1) };
    let options = Options { replans: false, ..options() };
    let mut bench = Bench::with(vec![(late, END - 10)], parameters(), options, |_, _| ());
    assert!(asks(&bench.tick(min(END - 10)), 1));
    let actions = bench.tick(min(END));
    assert!(actions.contains(&Action::Withdraw(id(1))), "{actions:?}");
    bench.event(min(END), Event::Granted(id(1)));
    assert!(!bench.runs(1));
    assert!(bench.control.is_over());
}
