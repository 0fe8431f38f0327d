//! What stands at the top, and the panels of named timelines below.

use faregate_planner::parameters::{TimelineKind, TimelineSpec};
use faregate_planner::picture::{Scene, draw};
use faregate_planner::plan::{Effect, Impact};
use faregate_planner::timed::{Excess, Limit, Line};

use super::{at, drawn, id, parameters, plan, projection, state, texts, timed, trace};

#[test]
fn what_must_not_be_overlooked_stands_at_the_top() {
    let mut timed = timed();
    let excess = |by, limit, amount| Excess { by, limit, at: at(1_200), amount };
    timed.rows.swap(0, 1);
    timed.rows.iter_mut().zip([id(1), id(2)]).for_each(|(row, id)| row.id = id);
    timed.excess =
        vec![excess(Some(id(2)), Limit::Data, 1_000), excess(Some(id(1)), Limit::Data, 5_000)];
    timed.unavoidable = vec![excess(None, Limit::Peak, 3_000)];
    let all = texts(&drawn(&plan(), &timed, None));
    for line in [
        "mandatory and left out: drive &lt;north&gt;",
        "unavoidable: 3 W above the peak power limit at 20:00",
        "drive &lt;north&gt;: 5 kB above the data volume at 20:00",
    ] {
        assert!(all.contains_key(line), "{line}: {all:#?}");
    }
    let smaller = "mast &amp; more: 1 kB above the data volume at 20:00";
    assert!(!all.contains_key(smaller), "of one limit the largest excess: {all:#?}");
    timed.unavoidable = (0..9).map(|mw| excess(None, Limit::Peak, mw)).collect();
    let all = texts(&drawn(&plan(), &timed, None));
    assert!(all.contains_key("and 8 more limits that are broken"), "{all:#?}");
    let good = texts(&drawn(&plan(), &super::timed(), None));
    assert!(!good.keys().any(|words| words.contains("mandatory and left out")), "{good:#?}");
}

#[test]
fn a_named_timeline_that_something_touches_is_drawn_with_its_limits() {
    let line = |name: &str, max| TimelineSpec {
        name: name.into(),
        kind: TimelineKind::Consumable,
        initial: 0,
        min: -2,
        max,
    };
    let mut parameters = parameters();
    parameters.timelines = vec![line("empty_tubes", 43), line("spare_tubes", 7)];
    let (mut plan, state, timed) = (plan(), state(), timed());
    let impact = Impact { timeline: "empty_tubes".into(), effect: Effect::AddAtEnd(-1) };
    plan.activities[1].impacts = vec![impact];
    let mut projection = projection();
    let points = vec![(at(480), 38), (at(600), 37)];
    let (name, unit) = ("empty_tubes".to_owned(), String::new());
    projection.lines.push(Line { name, unit, steps: true, points });
    let draw = |trace| {
        let (plan, parameters, state, timed) = (&plan, &parameters, &state, &timed);
        draw(&Scene { plan, parameters, state, timed, projection: &projection, trace })
    };
    let all = texts(&draw(None));
    for words in ["empty tubes", "maximum 43", "minimum -2"] {
        assert!(all.contains_key(words), "{words}: {all:#?}");
    }
    assert!(!all.contains_key("spare tubes") && !all.contains_key("maximum 7"), "{all:#?}");
    let trace = trace();
    let all = texts(&draw(Some(&trace)));
    assert!(all.contains_key("empty tubes"), "{all:#?}");
}
