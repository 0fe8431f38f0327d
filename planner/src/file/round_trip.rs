//! What is written is read as the same, by each way through both forms.

use core::cell::RefCell;
use std::collections::BTreeSet;

use faregate_scheduler::format::render;
use proptest::test_runner::{Config, TestRunner};

use crate::file::generated::three;
use crate::file::names::Names;
use crate::file::schema::{self, Known};
use crate::file::words::{MODES, OUTCOMES, STATUSES, TIMELINES, TYPES, VARIABLES};
use crate::file::xml::Element;
use crate::file::{Document, binary, read, to_binary, to_xml, write};
use crate::parameters::Parameters;

fn again(bytes: &[u8], parameters: Option<&Parameters>) -> Document {
    let found = match read("a.xml", bytes, parameters) {
        Ok(loaded) => return loaded.value,
        Err(found) => found,
    };
    panic!("{}\n{}", render(&found, bytes, false), String::from_utf8_lossy(bytes))
}

/// Each attribute that occurs in a text, with its element, and each word that
/// stands for a value of a list.
fn occur(element: &Element<'_>, root: &str, seen: &mut BTreeSet<String>) {
    for one in &element.attributes {
        seen.insert(format!("{root} {} {}", element.name, one.name));
        if ["type", "kind", "status", "mode", "outcome"].contains(&&*one.name) {
            seen.extend(one.value.split(' ').map(str::to_owned));
        }
    }
    element.children.iter().for_each(|child| occur(child, root, seen));
}

/// All that there are.
fn all(known: &Known, root: &str, seen: &mut BTreeSet<String>) {
    let one = |attribute: &&str| format!("{root} {} {attribute}", known.name);
    seen.extend(known.attributes.iter().map(one));
    known.children.iter().for_each(|child| all(child, root, seen));
}

#[test]
fn generated_documents_with_every_field_are_the_same_after_each_way() {
    let seen = RefCell::new(BTreeSet::new());
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::default() });
    let run = runner.run(&three(), |(parameters, plan, state)| {
        let names = [Some(&parameters), None];
        let documents = [
            Document::Plan(plan),
            Document::State(state),
            Document::Parameters(parameters.clone()),
        ];
        for (document, names) in documents.iter().flat_map(|one| names.map(|names| (one, names))) {
            let xml = to_xml(document, names);
            assert_eq!(&again(xml.as_bytes(), names), document, "{xml}");
            assert_eq!(to_xml(&again(xml.as_bytes(), names), names), xml);
            let compact = to_binary(document);
            assert_eq!(&again(&compact, names), document, "{xml}");
            assert_eq!(to_binary(&again(xml.as_bytes(), names)), compact);
            let element = write::element(document, &Names::new(names));
            occur(&element, &element.name, &mut seen.borrow_mut());
        }
        Ok(())
    });
    run.unwrap();
    // A field that never occurred was never tested.
    let mut wanted = BTreeSet::new();
    for root in [&schema::PLAN, &schema::PARAMETERS, &schema::STATE] {
        all(root, root.name, &mut wanted);
    }
    wanted.extend(TYPES.map(|(word, _)| word.to_owned()));
    // A generic activity is one that says nothing of its type.
    wanted.remove("generic");
    wanted.extend(STATUSES.map(|(word, _)| word.to_owned()));
    wanted.extend(OUTCOMES.map(|(word, _)| word.to_owned()));
    wanted.extend(VARIABLES.map(|(word, _)| word.to_owned()));
    wanted.extend(TIMELINES.map(|(word, _)| word.to_owned()));
    wanted.extend(MODES.map(|(word, _)| word.to_owned()));
    let seen = seen.into_inner();
    let never: Vec<_> = wanted.difference(&seen).collect();
    assert!(never.is_empty(), "never occurred: {never:?}");
}

#[test]
fn every_flipped_bit_and_every_truncation_of_a_compact_file_is_refused() {
    let mut runner =
        TestRunner::new(Config { cases: 6, failure_persistence: None, ..Config::default() });
    let run = runner.run(&three(), |(parameters, plan, state)| {
        let documents =
            [Document::Plan(plan), Document::State(state), Document::Parameters(parameters)];
        for document in documents {
            let good = to_binary(&document);
            assert_eq!(binary::document(&good).as_ref(), Ok(&document));
            for length in 0..good.len() {
                assert!(binary::document(&good[..length]).is_err(), "cut at {length}");
            }
            for at in 0..good.len() {
                for bit in 0..8 {
                    let mut bad = good.clone();
                    bad[at] ^= 1 << bit;
                    assert!(binary::document(&bad).is_err(), "bit {bit} of byte {at}");
                }
            }
            let mut longer = good.clone();
            longer.push(0);
            assert!(binary::document(&longer).is_err());
        }
        Ok(())
    });
    run.unwrap();
}
