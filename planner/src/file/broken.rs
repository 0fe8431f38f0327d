//! Good files in which some values are broken: those are told, each at its
//! place, and nothing else is.

use std::collections::BTreeSet;

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{Config, TestRunner};

use crate::file::generated::three;
use crate::file::{Document, read, to_xml};
use crate::parameters::Parameters;

/// What people call things: any words will do. Of `version` and `type` other
/// fields depend, and others refer to an `id` and to the names of parameters.
const NEVER: [&str; 9] =
    ["version", "type", "id", "name", "next_plan", "sequence", "group", "variable", "kind"];

/// A value in a text.
#[derive(Clone, Copy, Debug)]
struct Value {
    from: usize,
    to: usize,
    /// Which element it is in, by the place of its begin.
    element: usize,
}

/// Values that can be broken by themselves.
fn values(xml: &str) -> Vec<Value> {
    let mut values = Vec::new();
    let (mut at, mut element) = (0, 0);
    while let Some(found) = xml[at..].find(['<', '"']) {
        at += found + 1;
        if xml.as_bytes()[at - 1] == b'<' {
            element = at;
            continue;
        }
        let to = at + xml[at..].find('"').expect("each quote is closed");
        let before = xml[..at - 2].rfind(|one: char| !one.is_ascii_alphanumeric() && one != '_');
        let name = &xml[before.map_or(0, |before| before + 1)..at - 2];
        if xml[element..].starts_with(|one: char| one.is_ascii_lowercase())
            && !NEVER.contains(&name)
        {
            values.push(Value { from: at, to, element });
        }
        at = to + 1;
    }
    values
}

/// Some of them, at most one of an element: what is wrong with one field may
/// leave nothing to say of another.
fn some(values: &[Value], picks: &[Index]) -> Vec<Value> {
    let mut elements = BTreeSet::new();
    let picked = picks.iter().map(|pick| values[pick.index(values.len())]);
    let mut some: Vec<Value> = picked.filter(|value| elements.insert(value.element)).collect();
    some.sort_by_key(|value| value.from);
    some
}

/// The text with these values broken, and where they are then.
fn broken(xml: &str, values: &[Value]) -> (String, BTreeSet<usize>) {
    let (mut text, mut places, mut last) = (String::new(), BTreeSet::new(), 0);
    for (nth, value) in values.iter().enumerate() {
        text += &xml[last..value.from];
        places.insert(text.len());
        text += &format!("?{nth}");
        last = value.to;
    }
    (text + &xml[last..], places)
}

/// Where errors are told.
fn told(text: &str, parameters: &Parameters) -> BTreeSet<usize> {
    let found = read("a.xml", text.as_bytes(), Some(parameters)).err().unwrap_or_default();
    let errors = found.iter().filter(|one| one.is_error());
    errors.map(|one| one.place.span.start).collect()
}

fn exactly_those_are_told(document: &Document, parameters: &Parameters, picks: &[Index]) {
    let good = to_xml(document, Some(parameters));
    let (text, places) = broken(&good, &some(&values(&good), picks));
    assert!(!places.is_empty());
    assert_eq!(told(&text, parameters), places, "{text}");
    assert_eq!(told(&good, parameters), BTreeSet::new());
}

#[test]
fn of_a_file_with_some_broken_values_exactly_those_are_told() {
    let picks = prop::collection::vec(any::<Index>(), 1..7);
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::default() });
    let run = runner.run(&(three().boxed(), picks), |((parameters, plan, state), picks)| {
        exactly_those_are_told(&Document::Plan(plan), &parameters, &picks);
        exactly_those_are_told(&Document::State(state), &parameters, &picks);
        let own = Document::Parameters(parameters.clone());
        exactly_those_are_told(&own, &parameters, &picks);
        Ok(())
    });
    run.unwrap();
}
