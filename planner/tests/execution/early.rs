//! Slide "Vision": starts the next activity sooner, if the current activity
//! finishes early.

use faregate_agents::Categories;
use faregate_planner::execute::{Action, Options};
use faregate_planner::plan::{Outcome, StartRange};
use faregate_planner::timed::TimedPlan;
use faregate_planner::trace::Why;
use faregate_planner::units::{Bytes, Span};
use faregate_planner::{Activity, Plan, execute::Event};

use crate::bench::{Bench, activity, asks, id, is_started, min, options, parameters, watts};

const BIT: Categories = Categories::from_mask(1);

/// The first one, and the next one planned behind it with the same bit.
fn pair() -> Vec<(Activity, i64)> {
    let [a, b] = [1, 2].map(|number| Activity { resources: BIT, ..activity(number) });
    vec![(a, 0), (b, 10)]
}

#[test]
fn the_next_activity_starts_when_the_current_one_finishes_early() {
    let mut bench = Bench::new(pair());
    bench.starts(1, min(0));
    assert!(asks(&bench.ends(1, min(6), Outcome::Succeeded), 2));
    let actions = bench.event(min(6), Event::Granted(id(2)));
    let early = actions.iter().find_map(|action| match action {
        Action::Start(start) => Some((start.early, start.slot.end)),
        _ => None,
    });
    assert_eq!(early, Some((true, min(16))));
    let wanted = |action: &Action| matches!(action, Action::Replan(why) if why.contains(&Why::StartedEarly(id(2))));
    assert!(actions.iter().any(wanted), "{actions:?}");
}

#[test]
fn also_when_it_fails_or_is_vetoed() {
    let mut bench = Bench::new(pair());
    bench.starts(1, min(0));
    assert!(asks(&bench.ends(1, min(6), Outcome::Failed), 2));

    let mut bench = Bench::new(pair());
    bench.tick(min(0));
    assert!(asks(&bench.event(min(0), Event::Veto(id(1))), 2));
}

#[test]
fn not_in_the_plan_as_it_stands() {
    let mut bench = Bench::with(
        pair(),
        parameters(),
        Options { charge_holds: options().charge_holds, ..Options::STATIC },
        |_: &mut Plan, _| (),
    );
    bench.starts(1, min(0));
    let actions = bench.ends(1, min(6), Outcome::Succeeded);
    assert_eq!(actions, [], "no early start and no new plan");
    bench.starts(2, min(10));
}

#[test]
fn not_before_its_start_range_opens() {
    let mut activities = pair();
    activities[1].0.starts = vec![StartRange { from: min(7), to: min(100), cutoff: min(200) }];
    let mut bench = Bench::new(activities);
    bench.starts(1, min(0));
    assert!(!asks(&bench.ends(1, min(6), Outcome::Succeeded), 2));
}

#[test]
fn not_where_something_planned_would_have_to_start_later() {
    let mut activities = pair();
    // Nine minutes are left before it, and it takes ten.
    activities[1].1 = 30;
    activities.push((Activity { resources: BIT, ..activity(3) }, 15));
    let mut bench = Bench::new(activities);
    bench.starts(1, min(0));
    let actions = bench.ends(1, min(6), Outcome::Succeeded);
    assert_eq!([asks(&actions, 2), asks(&actions, 3)], [false, true]);
}

#[test]
fn not_where_the_sum_of_peaks_would_be_too_much() {
    let activities = [(1, 0), (2, 10), (3, 5)].map(|(number, at)| {
        (Activity { peak: watts(75), resources: Categories::NONE, ..activity(number) }, at)
    });
    let mut bench = Bench::new(activities.to_vec());
    bench.starts(1, min(0));
    bench.ends(1, min(4), Outcome::Succeeded);
    bench.event(min(4), Event::Granted(id(2)));
    assert!(!bench.runs(2), "60 W of the computer and two of 75 W are more than 200 W");
}

#[test]
fn not_where_the_computer_is_to_go_to_sleep_before_it_would_end() {
    let sleepy = |_: &mut Plan, timed: &mut TimedPlan| timed.awake[0].down = min(12);
    let mut bench = Bench::with(pair(), parameters(), options(), sleepy);
    bench.starts(1, min(0));
    assert!(!asks(&bench.ends(1, min(6), Outcome::Succeeded), 2));
}

#[test]
fn the_more_important_one_first() {
    let mut activities = pair();
    activities[1].0.priority = 60;
    activities.push((Activity { resources: BIT, priority: 70, ..activity(3) }, 20));
    let mut bench = Bench::new(activities);
    bench.starts(1, min(0));
    let actions = bench.ends(1, min(1), Outcome::Succeeded);
    // From minute 1 to 11 it would be in the way of what is planned for minute
    // 10; the other one is in nobody's way.
    assert_eq!([asks(&actions, 2), asks(&actions, 3)], [true, false]);
}

#[test]
fn without_tickets_in_time_it_waits_for_its_planned_start() {
    let mut bench = Bench::new(pair());
    bench.starts(1, min(0));
    assert!(asks(&bench.ends(1, min(6), Outcome::Succeeded), 2));
    let late = min(6).after(Span::from_secs(6));
    assert!(bench.tick(late).contains(&Action::Withdraw(id(2))));
    assert!(!is_started(&bench.event(late, Event::Granted(id(2))), 2));
    bench.starts(2, min(10));
}

/// One of two that together make too much is planned after a downlink: data that
/// were on board sooner would keep what is planned before it from starting.
#[test]
fn not_where_what_is_planned_would_find_too_much_data_on_board() {
    let data =
        |bytes, (one, at): (Activity, i64)| (Activity { data: Bytes::new(bytes), ..one }, at);
    let plain = |number| activity(number);
    for (bytes, starts) in [(500, true), (501, false)] {
        let downlink = Activity { duration: Span::from_mins(5), ..plain(3) };
        let mut bench = Bench::new(vec![
            (Activity { resources: BIT, ..plain(1) }, 0),
            data(bytes, (Activity { resources: BIT, ..plain(2) }, 50)),
            data(500, (plain(4), 20)),
            data(-500, (downlink, 40)),
        ]);
        bench.starts(1, min(0));
        assert_eq!(asks(&bench.ends(1, min(6), Outcome::Succeeded), 2), starts, "{bytes}");
    }
}

#[test]
fn not_without_the_charge_that_it_takes_or_leaves_for_handover() {
    let hungry = |percent| {
        let mut activities = pair();
        activities[1].0.marginal = watts(150);
        let mut bench = Bench::new(activities);
        bench.starts(1, min(0));
        bench.estimate(min(5), percent, true);
        asks(&bench.ends(1, min(6), Outcome::Succeeded), 2)
    };
    assert_eq!([hungry(80), hungry(41)], [true, false]);
}
