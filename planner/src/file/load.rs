//! Loading: whatever form a file has, it is judged by the same rules, whole or
//! not at all.

use faregate_scheduler::format::reading::{Report, Source, Wrong, shown};
use faregate_scheduler::format::{Diagnostic, Rule};

use crate::file::names::Names;
use crate::file::xml::{self, Element};
use crate::file::{Document, Loaded, binary, check, read, write};
use crate::parameters::Parameters;

/// What a file can be.
pub(super) const ROOTS: &str = "a plan, parameters or a state";

/// The element that each of them is, and what people call it.
const KINDS: [(&str, &str); 3] =
    [("plan", "a plan"), ("parameters", "parameters"), ("state", "a state")];

/// A file of another kind is not judged any further: what is wrong with it in
/// this place says nothing.
pub(super) fn read_as(
    name: &str,
    bytes: &[u8],
    parameters: Option<&Parameters>,
    wanted: &str,
) -> Result<Loaded<Document>, Vec<Diagnostic>> {
    let names = Names::new(parameters);
    if binary::is_binary(bytes) {
        return read_binary(name, bytes, &names);
    }
    let source = Source::new(name, bytes)?;
    let mut report = Report::new(&source);
    let root = xml::parse(source.text(), &mut report);
    let is = root.as_ref().and_then(|root| KINDS.iter().find(|(element, _)| *element == root.name));
    if let Some((root, (_, is))) = root.as_ref().zip(is)
        && wanted != ROOTS
        && wanted != *is
    {
        report.error(root.at.clone(), "", another(is, wanted));
        return Err(report.found);
    }
    let document = root.and_then(|root| from_element(&root, &names, &mut report));
    finish(document, report.found)
}

fn another(is: &str, wanted: &str) -> Wrong {
    Wrong::new(Rule::Format, format!("this is {is}")).expected(wanted)
}

pub(super) fn only<T>(
    name: &str,
    wanted: &str,
    loaded: Loaded<Document>,
    pick: impl FnOnce(Document) -> Option<T>,
) -> Result<Loaded<T>, Vec<Diagnostic>> {
    let Loaded { value, warnings } = loaded;
    let is = value.what();
    pick(value)
        .map(|value| Loaded { value, warnings })
        .ok_or_else(|| nowhere(name, another(is, wanted)))
}

/// What is wrong with a file that has no lines.
fn nowhere(name: &str, wrong: Wrong) -> Vec<Diagnostic> {
    let source = Source::new(name, b"").ok();
    let Some(source) = source else { return Vec::new() };
    let mut report = Report::new(&source);
    report.error(0..0, "", wrong);
    report.found
}

/// What the compact form has goes the way of what people write: it is judged
/// by the same rules, and nothing is loaded that could not be written.
fn read_binary(
    name: &str,
    bytes: &[u8],
    names: &Names<'_>,
) -> Result<Loaded<Document>, Vec<Diagnostic>> {
    let document = binary::document(bytes).map_err(|why| {
        let rule = match why {
            binary::NotRead::Version { .. } => Rule::Version,
            binary::NotRead::Damaged => Rule::Damaged,
            binary::NotRead::Other | binary::NotRead::Kind { .. } => Rule::Format,
        };
        nowhere(name, Wrong::new(rule, why.to_string()).expected(ROOTS))
    })?;
    let source = Source::new(name, b"")?;
    let mut report = Report::new(&source);
    let again = from_element(&write::element(&document, names), names, &mut report);
    if !report.found.iter().any(Diagnostic::is_error) && again.as_ref() != Some(&document) {
        let wrong = Wrong::new(Rule::Damaged, "the file has what no XML file can say");
        report.error(0..0, "", wrong.expected(ROOTS));
    }
    finish(again, report.found)
}

fn from_element(
    root: &Element<'_>,
    names: &Names<'_>,
    report: &mut Report<'_>,
) -> Option<Document> {
    let document = match &*root.name {
        "plan" => read::plan(root, names, report).map(|read| {
            check::plan(&read, names, report);
            Document::Plan(read.value)
        }),
        "parameters" => read::parameters(root, report).map(|read| {
            if read.good {
                check::parameters(&read, report);
            }
            Document::Parameters(read.value)
        }),
        "state" => read::state(root, names, report).map(|read| {
            if read.good {
                check::state(&read, report);
            }
            Document::State(read.value)
        }),
        other => {
            let wrong =
                Wrong::new(Rule::Format, format!("nobody knows a file of {}", shown(other)));
            report.error(root.at.clone(), "", wrong.expected("<plan>, <parameters> or <state>"));
            None
        }
    };
    if names.assumed.get() && !names.told() {
        let wrong = Wrong::new(Rule::Assumed, "nobody said which parameters this file goes with");
        let wrong = wrong.help("name the parameters' file, too: their days and names count");
        report.warn(root.at.clone(), "", wrong);
    }
    document
}

fn finish(
    document: Option<Document>,
    mut found: Vec<Diagnostic>,
) -> Result<Loaded<Document>, Vec<Diagnostic>> {
    found.sort_by_key(|wrong| (wrong.place.span.start, wrong.is_error()));
    match document {
        Some(value) if !found.iter().any(Diagnostic::is_error) => {
            Ok(Loaded { value, warnings: found })
        }
        _ => Err(found),
    }
}
