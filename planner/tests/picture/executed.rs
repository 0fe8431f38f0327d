//! The picture of an execution: what the ground ordered itself, what stands at
//! the top, and where words begin.

use faregate_planner::plan::{Kind, Outcome, StartRange};
use faregate_planner::timed::{Fate, Row, Slot};
use faregate_planner::trace::{Entry, Happened};
use faregate_planner::units::{Bytes, Span};
use faregate_planner::{Activity, Plan, TimedPlan};

use super::{at, drawn, id, plan, texts, timed, trace};

/// A third one, which the ground ordered itself, from 11:40 to 13:10.
fn with_a_shutdown() -> (Plan, TimedPlan) {
    let (mut plan, mut timed) = (plan(), timed());
    let minutes = Span::from_mins(5);
    plan.activities.push(Activity {
        name: Some("restart".into()),
        kind: Kind::ManualShutdown { shutdown: minutes, wakeup: minutes },
        priority: 60,
        starts: vec![StartRange { from: at(700), to: at(700), cutoff: at(790) }],
        ..Activity::new(id(3), Span::from_mins(90))
    });
    let slot = Slot { start: at(700), end: at(790), range: 0 };
    timed.rows.push(Row { id: id(3), fate: Fate::Scheduled(slot) });
    (plan, timed)
}

#[test]
fn the_grounds_own_shutdown_is_drawn_when_it_is_over_though_nobody_started_it() {
    let (plan, timed) = with_a_shutdown();
    let mut trace = trace();
    let row = "3  restart: 11:40 to 13:10";
    assert!(!texts(&drawn(&plan, &timed, Some(&trace))).contains_key(row));
    let over = Happened::Ended { id: id(3), outcome: Outcome::Succeeded, data: Bytes::ZERO };
    trace.entries.push(Entry { at: at(790), what: over });
    let all = texts(&drawn(&plan, &timed, Some(&trace)));
    assert!(all.contains_key(row), "{all:#?}");
    assert!(all.contains_key("08:00 to 24:00; executed: 1 succeeded, 1 aborted, 1 not started"));
}

#[test]
fn what_is_mandatory_and_was_not_done_stands_at_the_top() {
    let (plan, timed) = with_a_shutdown();
    let all = texts(&drawn(&plan, &timed, Some(&trace())));
    let undone = "mandatory and not done: drive &lt;north&gt;, restart";
    assert!(all.contains_key(undone), "{all:#?}");
    let mut good = trace();
    let succeeds = |number| Entry {
        at: at(790),
        what: Happened::Ended { id: id(number), outcome: Outcome::Succeeded, data: Bytes::ZERO },
    };
    good.entries.extend([succeeds(1), succeeds(3)]);
    let all = texts(&drawn(&plan, &timed, Some(&good)));
    assert!(!all.keys().any(|words| words.contains("not done")), "{all:#?}");
}

/// Where the text with these words begins.
fn begin(picture: &str, words: &str) -> f64 {
    // The first one is what a pointer shows.
    let (before, _) = picture.rsplit_once(words).expect("it is there");
    let tag = before.rsplit("<text").next().expect("it is a text");
    let x = tag.split(" x=\"").nth(1).and_then(|rest| rest.split('"').next());
    x.and_then(|x| x.parse().ok()).expect("it has a place")
}

#[test]
fn a_reason_does_not_lie_on_what_was_planned() {
    let (plan, mut timed) = (plan(), timed());
    let reason = "10 Wh below";
    let free = begin(&drawn(&plan, &timed, Some(&trace())), reason);
    // From 10:20 on, beside the cross at 10:10.
    timed.rows[1].fate = Fate::Scheduled(Slot { start: at(620), end: at(680), range: 0 });
    let beside = begin(&drawn(&plan, &timed, Some(&trace())), reason);
    assert!(beside > free + 20.0, "{beside} {free}");
}
