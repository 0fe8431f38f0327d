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

/// Which rules a changed template breaks.
fn broken(template: &str, from: &str, to: &str) -> Vec<String> {
    let names = parameters();
    let rules = wrong(&with(template, &[(from, to)]), Some(&names));
    rules.iter().map(|one| one.split_once(' ').unwrap().1.to_owned()).collect()
}

#[test]
fn what_cannot_be_read_is_told_all_at_once_with_line_and_column() {
    let text = r#"<?xml version="1.0"?>
<plan version="1" name="a" handover="10:00" handover_min_soc="120 %" end="25:00" max_delta_data="1.5 B">
  <activity id="0" priority="-1" duration="25" marginal="12.0005 W" colour="red">
    <start from="10:61" to="soon" cutoff="9"/>
    <uses zone="mast" bit="3"/>
    <uses bit="128"/>
    <condition kind="XYZ" variable="a" min="5" max="4"/>
    <impact timeline="arm"/>
    text
    <nothing/>
  </activity>
  <activity id="2" priority="1" duration="25 km" energy="1e3 J" type="expandin" peak="5"/>
</plan>
"#;
    let found = wrong(text, None);
    let expected = [
        "2:63 !range",
        "2:75 !range",
        "2:98 !range",
        "3:17 !range",
        "3:30 !range",
        "3:58 !range",
        "3:69 !unknown",
        "4:18 !value",
        "4:29 !value",
        "5:28 !duplicate",
        "6:16 !range",
        "7:22 !unknown",
        "7:53 !limits",
        "8:6 !missing",
        "9:5 !unknown",
        "10:6 !unknown",
        "12:4 !missing",
        "12:43 !value",
        "12:58 !value",
        "12:71 !unknown",
        "12:87 !value",
    ];
    for one in expected {
        assert!(found.iter().any(|found| found == one), "{one} is not in {found:#?}");
    }
    let told = |one: &String| expected.contains(&one.as_str()) || one.ends_with("?assumed");
    assert!(found.iter().all(told), "{found:#?}");
}

#[test]
fn what_is_no_xml_is_told_with_its_place() {
    let plan = "<plan version=\"1\"";
    for (text, expected) in [
        ("", "1:1 !missing"),
        ("<plan>\n  <activity>\n</plan>", "3:1 !syntax"),
        ("<plan>\n", "1:2 !syntax"),
        ("<plan a=1 b='2'/>", "1:9 !syntax"),
        ("<plan a='1' a='2'/>", "1:13 !duplicate"),
        ("<plan a='&nobody;'/>", "1:10 !syntax"),
        ("<!DOCTYPE plan [<!ENTITY a 'b'>]><plan/>", "1:1 !syntax"),
        ("<?xml version='1.0' encoding='latin1'?><plan/>", "1:1 !encoding"),
        ("<sequence version='1'/>", "1:2 !format"),
        ("<plan version='2'/>", "1:16 !version"),
        (plan, "1:1 !syntax"),
    ] {
        let found = wrong(text, None);
        assert!(found.iter().any(|one| one == expected), "{text}: {found:?}");
    }
    let deep = "<plan>".repeat(100_000);
    assert!(wrong(&deep, None).contains(&"1:50 !unknown".to_owned()));
}
