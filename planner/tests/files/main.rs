//! Files: read, judged, written, and read again.

mod judged;
mod read;

use faregate_planner::file::{self, Document, Loaded};
use faregate_planner::{Parameters, Plan, State};
use faregate_scheduler::format::{Diagnostic, render};

const PLAN: &str = include_str!("../../templates/plan.xml");
const PARAMETERS: &str = include_str!("../../templates/parameters.xml");
const STATE: &str = include_str!("../../templates/state.xml");

fn good<T>(text: &str, read: Result<Loaded<T>, Vec<Diagnostic>>) -> T {
    let loaded = read.unwrap_or_else(|found| panic!("{}", render(&found, text.as_bytes(), false)));
    assert_eq!(loaded.warnings, [], "{}", render(&loaded.warnings, text.as_bytes(), false));
    loaded.value
}

fn parameters() -> Parameters {
    good(PARAMETERS, file::parameters("parameters.xml", PARAMETERS.as_bytes()))
}

fn plan() -> Plan {
    good(PLAN, file::plan("plan.xml", PLAN.as_bytes(), Some(&parameters())))
}

fn state() -> State {
    good(STATE, file::state("state.xml", STATE.as_bytes(), Some(&parameters())))
}

#[test]
fn the_templates_are_the_same_after_each_way_through_each_form() {
    let names = parameters();
    let all =
        [Document::Plan(plan()), Document::Parameters(parameters()), Document::State(state())];
    for document in all {
        for parameters in [Some(&names), None] {
            let xml = file::to_xml(&document, parameters);
            let read = file::read("a.xml", xml.as_bytes(), parameters);
            assert_eq!(read.map(|read| read.value).as_ref(), Ok(&document), "{xml}");
            let binary = file::to_binary(&document);
            let read = file::read("a.plan", &binary, parameters);
            assert_eq!(read.map(|read| read.value).as_ref(), Ok(&document));
        }
    }
}

/// What is wrong with a text: where, by which rule, and what is said.
fn wrong(text: &str, parameters: Option<&Parameters>) -> Vec<String> {
    let found = match file::read("a.xml", text.as_bytes(), parameters) {
        Ok(loaded) => loaded.warnings,
        Err(found) => found,
    };
    let line = |one: &Diagnostic| {
        let (sign, place) = (if one.is_error() { '!' } else { '?' }, &one.place);
        format!("{}:{} {sign}{}", place.line, place.column, one.rule.name())
    };
    found.iter().map(line).collect()
}

/// The template with pieces replaced: each must be in it exactly once.
fn with(template: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(template.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    })
}

#[test]
fn a_file_of_another_kind_is_refused_in_either_form() {
    let names = parameters();
    for bytes in [STATE.as_bytes().to_vec(), file::to_binary(&Document::State(state()))] {
        let found = file::plan("x", &bytes, Some(&names)).unwrap_err();
        assert!(found[0].to_string().contains("this is a state; expected a plan"), "{found:?}");
    }
}

#[test]
fn a_file_in_the_place_of_another_is_told_and_not_judged() {
    // Without parameters the state's names would be unknown, which is not what
    // is wrong.
    for (text, is) in [(STATE, "a state"), (PLAN, "a plan")] {
        let found = file::parameters("x.xml", text.as_bytes()).unwrap_err();
        let told: Vec<_> = found.iter().map(ToString::to_string).collect();
        let expected = format!("this is {is}; expected parameters");
        assert!(told.len() == 1 && told[0].contains(&expected), "{told:?}");
    }
    let names = parameters();
    let found = file::state("x.xml", PLAN.as_bytes(), Some(&names)).unwrap_err();
    assert!(found[0].to_string().contains("this is a plan; expected a state"), "{found:?}");
}

#[test]
fn compact_files_are_judged_as_xml_is() {
    let names = parameters();
    let mut late = plan();
    late.handover = late.end.after(faregate_planner::units::Span::new(1));
    let found = file::read("x.bin", &file::to_binary(&Document::Plan(late)), Some(&names));
    let found = found.unwrap_err();
    assert!(
        found[0].to_string().contains("x.bin:1:1: error: the plan: the next plan takes over after")
    );
    let mut unsayable = plan();
    unsayable.name = "a\nb".into();
    let found = file::read("x.bin", &file::to_binary(&Document::Plan(unsayable)), Some(&names));
    assert!(found.is_err());
}

#[test]
fn compact_files_of_another_version_or_kind_are_refused() {
    use faregate_planner::file::binary::{self, NotRead};
    let good = binary::write(&plan());
    let mut newer = good.clone();
    newer[8] = 2;
    assert_eq!(binary::read::<Plan>(&newer), Err(NotRead::Version { found: 2 }));
    let wanted = NotRead::Kind { found: "a plan", wanted: "a state" };
    assert_eq!(binary::read::<State>(&good), Err(wanted));
    let timed = faregate_planner::TimedPlan::default();
    assert_eq!(binary::read(&binary::write(&timed)), Ok(timed));
    assert_eq!(binary::read::<Plan>(b"<plan/>"), Err(NotRead::Other));
}

#[test]
fn files_of_this_version_can_still_be_read() {
    let files = [
        (&include_bytes!("../compact/plan.bin")[..], Document::Plan(plan())),
        (&include_bytes!("../compact/parameters.bin")[..], Document::Parameters(parameters())),
        (&include_bytes!("../compact/state.bin")[..], Document::State(state())),
    ];
    let names = parameters();
    for (bytes, document) in files {
        let read = file::read("a.bin", bytes, Some(&names)).map(|loaded| loaded.value);
        let why = "the models have changed: so must file::VERSION, and tests/compact is to be \
                   written again with `faregate plan convert`; or a template has changed";
        assert_eq!(read.as_ref(), Ok(&document), "{why}");
        assert_eq!(file::to_binary(&document), bytes, "{why}");
    }
}
