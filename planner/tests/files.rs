//! Files: read, judged, written, and read again.

use faregate_planner::file::{self, Document, Loaded};
use faregate_planner::{Parameters, Plan, State};
use faregate_scheduler::format::{Diagnostic, render};

const PLAN: &str = include_str!("../templates/plan.xml");
const PARAMETERS: &str = include_str!("../templates/parameters.xml");
const STATE: &str = include_str!("../templates/state.xml");

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
