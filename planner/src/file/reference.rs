//! The reference (docs/plan-format.md) and the schema (plan.xsd) say what the
//! reader knows, and no more.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

use faregate_scheduler::format::{Rule, render};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::file::generated::three;
use crate::file::schema::{self, Known};
use crate::file::template;
use crate::file::{Document, parameters, read, to_xml};

const REFERENCE: &str = include_str!("../../../docs/plan-format.md");
const SCHEMA: &str = include_str!("../../plan.xsd");

/// The first cells of the tables under this heading.
fn listed(heading: &str) -> Vec<&'static str> {
    let (_, section) = REFERENCE.split_once(&format!("\n{heading}\n")).expect(heading);
    let end = section.find("\n#").unwrap_or(section.len());
    let rows = section[..end].lines().filter_map(|line| line.strip_prefix("| `"));
    rows.filter_map(|row| row.split('`').next()).collect()
}

fn heading(known: &Known, root: &Known) -> String {
    match (root.name, known.name) {
        ("state", "timeline") => "### `timeline` of a state".into(),
        ("state", "uses") => "### `uses` of a window".into(),
        (_, name) => format!("### `{name}`"),
    }
}

fn compare(known: &Known, root: &Known) {
    let heading = heading(known, root);
    assert_eq!(listed(&heading), known.attributes, "{heading}");
    known.children.iter().for_each(|child| compare(child, root));
}

#[test]
fn the_reference_lists_every_element_and_attribute_and_no_other() {
    for root in [&schema::PLAN, &schema::PARAMETERS, &schema::STATE] {
        compare(root, root);
    }
    assert_eq!(REFERENCE.matches("\n### `").count(), known().len());
}

#[test]
fn the_reference_lists_the_rules_of_the_planner() {
    let rules = listed("## What is wrong with a file");
    for rule in Rule::PLANNER {
        assert!(rules.contains(&rule.name()), "{} is missing", rule.name());
    }
    let known = Rule::ALL.map(Rule::name);
    assert!(rules.iter().all(|rule| known.contains(rule)), "{rules:?}");
    // Those that a test or a reader here names.
    let sources = [
        include_str!("check/activity.rs"),
        include_str!("check/dependencies.rs"),
        include_str!("check/overflow.rs"),
        include_str!("check/parameters.rs"),
        include_str!("check/plan.rs"),
        include_str!("check/state.rs"),
        include_str!("check/together.rs"),
        include_str!("fields.rs"),
        include_str!("names.rs"),
        include_str!("read.rs"),
        include_str!("read/activity.rs"),
        include_str!("read/parameters.rs"),
        include_str!("read/state.rs"),
        include_str!("times.rs"),
        include_str!("value.rs"),
        include_str!("words.rs"),
        include_str!("xml.rs"),
        include_str!("../file.rs"),
    ];
    let told = |rule: &&Rule| sources.iter().any(|text| text.contains(&format!("Rule::{rule:?}")));
    for rule in Rule::ALL.iter().filter(told) {
        assert!(rules.contains(&rule.name()), "{} is missing", rule.name());
    }
}

/// The examples of the reference, in their order.
fn examples() -> Vec<&'static str> {
    let blocks = REFERENCE.split("```xml\n").skip(1);
    blocks.filter_map(|block| block.split("```").next()).collect()
}

#[test]
fn the_examples_of_the_reference_can_be_loaded() {
    let [plan, own, state] = examples()[..] else { panic!("there are three") };
    let known = parameters("parameters.xml", own.as_bytes()).unwrap().value;
    for (text, is) in [(plan, "a plan"), (own, "parameters"), (state, "a state")] {
        let read = read("a.xml", text.as_bytes(), Some(&known))
            .unwrap_or_else(|found| panic!("{}", render(&found, text.as_bytes(), false)));
        assert_eq!((read.value.what(), read.warnings), (is, Vec::new()));
    }
}

/// What the schema says of an element: attributes, and children.
type Said = BTreeMap<String, (Vec<String>, Vec<String>)>;

/// Elements by the path of their names.
fn said() -> Said {
    let (mut said, mut path) = (Said::new(), Vec::<String>::new());
    let mut reader = Reader::from_str(SCHEMA);
    reader.config_mut().expand_empty_elements = true;
    loop {
        match reader.read_event().unwrap() {
            Event::Start(tag) => match (tag.name().0, named(&tag)) {
                ("xs:element", Some(name)) => {
                    if let Some((_, children)) = said.get_mut(&path.join("/")) {
                        children.push(name.clone());
                    }
                    path.push(name);
                    said.insert(path.join("/"), Default::default());
                }
                ("xs:attribute", Some(name)) => {
                    said.get_mut(&path.join("/")).unwrap().0.push(name);
                }
                _ => {}
            },
            Event::End(tag) if tag.name().0 == "xs:element" => {
                path.pop();
            }
            Event::Eof => return said,
            _ => {}
        }
    }
}

fn named(tag: &BytesStart<'_>) -> Option<String> {
    tag.try_get_attribute("name").unwrap().map(|name| name.value.into_owned())
}

/// The same of what the reader knows.
fn known() -> Said {
    let mut all = Said::new();
    for root in [&schema::PLAN, &schema::PARAMETERS, &schema::STATE] {
        expected(root, root.name, &mut all);
    }
    all
}

fn expected(known: &Known, path: &str, all: &mut Said) {
    let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect::<Vec<_>>();
    let children = known.children.iter().map(|child| child.name).collect();
    all.insert(path.to_owned(), (owned(known.attributes.to_vec()), owned(children)));
    for child in known.children {
        expected(child, &format!("{path}/{}", child.name), all);
    }
}

#[test]
fn the_schema_has_every_element_and_attribute_and_no_other() {
    assert_eq!(said(), known());
}

/// Whether `xmllint` finds a text to be as the schema says; `None`: there is
/// none.
fn valid(text: &str) -> Option<Result<(), String>> {
    let folder = tempfile::tempdir().unwrap();
    let (file, schema) = (folder.path().join("a.xml"), folder.path().join("plan.xsd"));
    std::fs::write(&file, text).unwrap();
    std::fs::write(&schema, SCHEMA).unwrap();
    let mut program = Command::new("xmllint");
    program.args(["--nonet", "--noout", "--schema"]).args([&schema, &file]);
    let output = program.stdin(Stdio::null()).output().ok()?;
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    Some(if output.status.success() { Ok(()) } else { Err(why) })
}

#[test]
fn another_program_finds_what_is_read_and_written_valid_by_the_schema() {
    if valid(template::PLAN).is_none() {
        println!("skipped: there is no xmllint (apt-get install libxml2-utils)");
        return;
    }
    let mut texts: Vec<String> = examples().into_iter().map(str::to_owned).collect();
    texts.extend([template::PLAN, template::PARAMETERS, template::STATE].map(str::to_owned));
    let mut runner = TestRunner::deterministic();
    for _ in 0..16 {
        let (parameters, plan, state) = three().new_tree(&mut runner).unwrap().current();
        for names in [Some(&parameters), None] {
            texts.push(to_xml(&Document::Plan(plan.clone()), names));
            texts.push(to_xml(&Document::State(state.clone()), names));
        }
        texts.push(to_xml(&Document::Parameters(parameters), None));
    }
    for text in &texts {
        assert_eq!(valid(text), Some(Ok(())), "{text}");
    }
    // It can say no, too.
    for (good, bad) in [
        ("id=\"6\"", "id=\"5\""),
        ("id=\"6\"", ""),
        ("20 min", "20 mi"),
        ("120 MB", "120 M"),
        ("55 %", "55"),
        ("1T06:30", "1T06:60"),
        ("\"stay_awake\"", "\"stay\""),
        ("FAILED ABORTED", ""),
        ("pausable", "can_pause"),
    ] {
        assert_eq!(template::PLAN.matches(good).count(), 1, "{good}");
        assert!(valid(&template::PLAN.replace(good, bad)).unwrap().is_err(), "{good} -> {bad}");
    }
}
