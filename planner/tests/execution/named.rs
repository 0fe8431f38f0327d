//! Named timelines: what starts, runs and ends changes them, and what an activity
//! asks of them is asked again when it starts.

use faregate_planner::Activity;
use faregate_planner::execute::NotReady;
use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::plan::{Constraint, Effect, Impact, Outcome};
use faregate_planner::timed::Limit;

use crate::bench::{Bench, activity, asks, id, min, options, parameters};

fn bench(kind: TimelineKind, activities: Vec<(Activity, i64)>) -> Bench {
    let mut parameters = parameters();
    parameters.timelines =
        vec![TimelineSpec { name: "film".into(), kind, initial: 40, min: 0, max: 100 }];
    Bench::with(activities, parameters, options(), |_, _| ())
}

fn with(effect: Effect, one: Activity) -> Activity {
    Activity { impacts: vec![Impact { timeline: "film".into(), effect }], ..one }
}

fn asking(min: i64, max: i64, one: Activity) -> Activity {
    Activity { constraints: vec![Constraint { timeline: "film".into(), min, max }], ..one }
}

fn film(bench: &Bench) -> i64 {
    bench.control.state().timelines.get("film").copied().unwrap_or(40)
}

#[test]
fn what_is_used_up_while_it_runs_is_not_there_any_more() {
    let uses = with(Effect::Rate(-1), activity(1));
    let mut bench = bench(TimelineKind::Consumable, vec![(uses, 0)]);
    bench.starts(1, min(0));
    let half = min(0).after(faregate_planner::units::Span::new(20_500));
    bench.tick(half);
    assert_eq!(film(&bench), 19, "rounded down");
    bench.ends(1, half, Outcome::Succeeded);
    bench.tick(min(5));
    assert_eq!(film(&bench), 19);
}

#[test]
fn what_an_activity_asks_of_a_timeline_is_so_when_it_starts() {
    let adds = with(Effect::AddAtStart(10), activity(1));
    let mut bench = bench(
        TimelineKind::Consumable,
        vec![(adds, 0), (asking(0, 50, activity(2)), 20), (asking(0, 49, activity(3)), 20)],
    );
    bench.starts(1, min(0));
    bench.ends(1, min(10), Outcome::Succeeded);
    let actions = bench.tick(min(20));
    assert_eq!([asks(&actions, 2), asks(&actions, 3)], [true, false]);
    let waits = Some(NotReady::Limit(Limit::Timeline("film".into())));
    assert_eq!(bench.control.waits_for(id(3)), waits);
}

#[test]
fn nothing_starts_where_there_is_no_room_for_what_it_takes() {
    for (held, starts) in [(60, true), (61, false)] {
        let holds = with(Effect::Hold(held), activity(1));
        let mut bench = bench(TimelineKind::Renewable, vec![(holds, 5)]);
        assert_eq!(asks(&bench.tick(min(5)), 1), starts, "{held}");
    }
    for (taken, starts) in [(-40, true), (-41, false)] {
        let takes = with(Effect::AddAtStart(taken), activity(1));
        let mut bench = bench(TimelineKind::Consumable, vec![(takes, 5)]);
        assert_eq!(asks(&bench.tick(min(5)), 1), starts, "{taken}");
    }
}
