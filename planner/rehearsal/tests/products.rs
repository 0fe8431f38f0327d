//! Slide "Plan file": "the flight software generates files (data products)
//! recording the schedule and other internal state". Each is written, and each
//! is read again as what it was written from.

mod support;

use std::sync::Arc;

use faregate_planner::products::{self, Product};
use faregate_planner::state::State;
use faregate_planner::timed::{Projection, TimedPlan};
use faregate_planner::trace::{Happened, Trace, Why};
use faregate_planner::units::Time;
use faregate_planner::{Activity, Parameters, Plan, file};
use faregate_rehearsal::{Setup, rehearse};
use serde::de::DeserializeOwned;
use support::{activity, early, id, min, planner, setup, started, when};

/// A handover at minute 60, after which another plan is executed; one activity
/// that cannot be placed, and one that ends early.
fn executed() -> (Setup, Trace, Vec<Product>) {
    let hopeless = Activity { name: Some("hopeless".into()), engines: 9, ..activity(4) };
    let mut setup = setup(vec![activity(1), activity(2), hopeless]);
    setup.draws.set(id(1), early(500));
    let end = min(900);
    let name = "next".to_owned();
    let next = Plan { name, handover: end, end, activities: vec![activity(7)], ..Plan::default() };
    setup.plan = Arc::new(Plan {
        name: "first".into(),
        handover: min(60),
        next_plan: Some("next".into()),
        ..Plan::clone(&setup.plan)
    });
    let setup = setup.followed_by(Arc::new(next));
    let trace = rehearse(&setup, &mut planner).expect("there is a plan");
    let products = products::of(&setup.plan, &setup.parameters, &trace, "test 7.0");
    (setup, trace, products.expect("everything can be said"))
}

fn content<'a>(products: &'a [Product], name: &str) -> &'a str {
    let found = products.iter().find(|one| one.name == name);
    let names: Vec<_> = products.iter().map(|one| &one.name).collect();
    &found.unwrap_or_else(|| panic!("there is no {name} in {names:?}")).content
}

fn json<T: DeserializeOwned>(products: &[Product], name: &str) -> T {
    serde_json::from_str(content(products, name)).unwrap_or_else(|why| panic!("{name}: {why}"))
}

fn plan(products: &[Product], name: &str, parameters: &Parameters) -> Plan {
    let read = file::plan(name, content(products, name).as_bytes(), Some(parameters));
    read.unwrap_or_else(|wrong| panic!("{name}: {wrong:?}")).value
}

fn parameters(products: &[Product]) -> Parameters {
    let text = content(products, "parameters.xml");
    file::parameters("parameters.xml", text.as_bytes()).expect("it was written").value
}

/// When each timed plan was made, why, from what, and what it is.
fn rounds(trace: &Trace) -> Vec<(Time, &[Why], &State, &TimedPlan)> {
    let entries = trace.entries.iter();
    let planned = entries.filter_map(|entry| match &entry.what {
        Happened::Planned { why, state, timed } => {
            Some((entry.at, why.as_slice(), &**state, &**timed))
        }
        _ => None,
    });
    planned.collect()
}

#[test]
fn the_parameters_and_each_plan_are_in_it() {
    let (setup, trace, products) = executed();
    assert_eq!(parameters(&products), *setup.parameters);
    assert_eq!(plan(&products, "plan.xml", &setup.parameters), *setup.plan);
    let taken_over = trace.entries.iter().find_map(|entry| match &entry.what {
        Happened::HandedOver(next) => Some(&**next),
        _ => None,
    });
    let next = plan(&products, "plan-2.xml", &setup.parameters);
    assert_eq!(Some(&next), taken_over, "with what ran then");
}

#[test]
fn each_schedule_is_in_it_with_when_why_and_the_state_it_was_made_from() {
    let (setup, trace, products) = executed();
    let rounds = rounds(&trace);
    assert!(rounds.len() > 2, "{}", rounds.len());
    let index: Vec<serde_json::Value> = json(&products, "rounds.json");
    assert_eq!(index.len(), rounds.len());
    for (listed, (at, why, state, timed)) in index.iter().zip(&rounds) {
        let folder = listed["folder"].as_str().expect("it is one");
        assert_eq!(listed["at"].as_i64(), Some(at.get()));
        assert_eq!(listed["why"], serde_json::to_value(why).expect("words"));
        assert_eq!(json::<TimedPlan>(&products, &format!("{folder}/schedule.json")), **timed);
        let name = format!("{folder}/state.xml");
        let text = content(&products, &name).as_bytes();
        let read = file::state(&name, text, Some(&setup.parameters)).expect("it was written");
        assert_eq!(read.value, **state);
    }
    let handed_over = |round: &&serde_json::Value| round["plan"] == "plan-2.xml";
    assert!(index.iter().any(|round| round["plan"] == "plan.xml"));
    let after = index.iter().find(handed_over).and_then(|round| round["at"].as_i64());
    let taken_over = when(&trace, |what| matches!(what, Happened::HandedOver(_)));
    assert!(after.is_some_and(|at| Some(Time::new(at)) >= taken_over), "{after:?}");
}

#[test]
fn each_activity_is_in_words_with_when_it_runs_or_why_not() {
    let (_, _, products) = executed();
    let said = content(&products, "0001/schedule.txt");
    for number in [1, 2] {
        let row = said.lines().find(|line| line.starts_with(&format!("{number} ")));
        assert!(row.is_some_and(|row| row.contains(" to ")), "{said}");
    }
    let left_out = "4 hopeless: left out: 2 sequence engines too many at 00:10";
    assert!(said.lines().any(|line| line.starts_with(left_out)), "{said}");
    assert!(said.lines().any(|line| line.starts_with("awake: ")), "{said}");
}

#[test]
fn the_timelines_of_each_schedule_begin_with_its_state_and_go_on_to_the_end() {
    let (setup, trace, products) = executed();
    for (number, (_, _, state, _)) in (1..).zip(rounds(&trace)) {
        let projection: Projection = json(&products, &format!("{number:04}/timelines.json"));
        let names: Vec<_> = projection.lines.iter().map(|line| line.name.as_str()).collect();
        assert_eq!(names, ["charge", "peak", "data", "engines", "awake"]);
        let charge = &projection.lines[0].points;
        let now = i64::try_from(state.charge.get()).expect("small");
        assert_eq!(charge.first(), Some(&(state.now, now)));
        let plan = if state.now < min(60) { &setup.plan } else { setup.next.as_ref().unwrap() };
        assert_eq!(charge.last().map(|(at, _)| *at), Some(plan.end));
    }
}

#[test]
fn what_happened_can_be_held_against_the_rules_from_the_files_alone() {
    let (_, trace, products) = executed();
    let read: Trace = json(&products, "happened.json");
    assert_eq!(read, trace);
    assert!(started(&read, 7) > started(&read, 1), "what ran under each plan");
    let parameters = parameters(&products);
    let plan = plan(&products, "plan.xml", &parameters);
    assert_eq!(faregate_checker::check_trace(&plan, &parameters, &read), []);
    // The control: without its dispatches it is not what a rover does.
    let mut silent = read;
    silent.entries.retain(|entry| !matches!(entry.what, Happened::Dispatched(_)));
    assert_ne!(faregate_checker::check_trace(&plan, &parameters, &silent), []);
}

#[test]
fn the_versions_and_checksums_of_what_was_used_are_in_it() {
    let (setup, _, products) = executed();
    let versions: serde_json::Value = json(&products, "versions.json");
    assert_eq!(versions["program"], "test 7.0");
    assert_eq!(versions["files"], file::VERSION);
    assert_eq!(versions["products"], products::VERSION);
    let of = |compact: &[u8]| {
        let sum = compact.last_chunk().copied().map_or(0, u32::from_le_bytes);
        format!("{sum:08x}")
    };
    let wanted = [
        ("parameters.xml", of(&file::binary::write(&*setup.parameters))),
        ("plan.xml", of(&file::binary::write(&*setup.plan))),
    ];
    let told = versions["checksums"].as_array().expect("a list");
    let told = told.iter().map(|one| (one[0].as_str(), one[1].as_str()));
    let told: Vec<_> = told.map(|(name, sum)| (name.unwrap(), sum.unwrap())).collect();
    assert_eq!(told.len(), 3, "the plan that took over, too: {told:?}");
    for ((name, sum), (told_name, told_sum)) in wanted.iter().zip(&told) {
        assert_eq!((*name, sum.as_str()), (*told_name, *told_sum));
    }
    assert_ne!(told[1].1, told[2].1, "two plans are told from each other");
}
