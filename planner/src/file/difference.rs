//! What changed between two documents, field by field.

use core::fmt;
use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::file::names::Names;
use crate::file::xml::Element;
use crate::file::{Document, write};
use crate::parameters::Parameters;

/// Something that changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// What it is in: `activity 12`, `activity 12, start #2`; empty for the whole.
    pub at: String,
    /// What became of it.
    #[serde(flatten)]
    pub change: Change,
}

/// What became of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Change {
    /// It is new: with these fields.
    Added(String),
    /// It is gone: it had these.
    Removed(String),
    /// It stands at another place among its like, which decides among equals.
    Moved,
    /// A field of it has another value.
    Set {
        /// Which one.
        field: String,
        /// What it was; none: nothing stood there.
        from: Option<String>,
        /// What it is; none: nothing stands there.
        to: Option<String>,
    },
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, change } = self;
        let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "nothing".into());
        match change {
            Change::Added(fields) => write!(f, "+ {at}: {fields}"),
            Change::Removed(fields) => write!(f, "- {at}: {fields}"),
            Change::Moved => write!(f, "~ {at}: stands elsewhere among its like"),
            Change::Set { field, from, to } => {
                let between = if at.is_empty() { "" } else { ": " };
                write!(f, "~ {at}{between}{field}: {} -> {}", shown(from), shown(to))
            }
        }
    }
}

/// What changed from one document to the other, in the order of the second;
/// `None`: they are not of the same kind. Values are shown as files with these
/// parameters have them.
#[must_use]
pub fn differences(
    before: &Document,
    after: &Document,
    parameters: Option<&Parameters>,
) -> Option<Vec<Difference>> {
    let names = Names::new(parameters);
    let (before, after) = (write::element(before, &names), write::element(after, &names));
    let mut found = Vec::new();
    (before.name == after.name).then(|| {
        compare("", &before, &after, &mut found);
        found
    })
}

fn compare(at: &str, before: &Element<'_>, after: &Element<'_>, found: &mut Vec<Difference>) {
    for one in &after.attributes {
        let was = before.attribute(&one.name).map(|was| was.value.to_string());
        if was.as_deref() != Some(&*one.value) {
            set(at, &one.name, was, Some(one.value.to_string()), found);
        }
    }
    for gone in before.attributes.iter().filter(|one| after.attribute(&one.name).is_none()) {
        set(at, &gone.name, Some(gone.value.to_string()), None, found);
    }
    children(at, &labelled(before), &labelled(after), found);
}

fn set(
    at: &str,
    field: &str,
    from: Option<String>,
    to: Option<String>,
    found: &mut Vec<Difference>,
) {
    let change = Change::Set { field: field.to_owned(), from, to };
    found.push(Difference { at: at.to_owned(), change });
}

/// Elements, each with what it is called among its like.
type Labelled<'e> = Vec<(String, &'e Element<'e>)>;

fn children(at: &str, before: &Labelled<'_>, after: &Labelled<'_>, found: &mut Vec<Difference>) {
    let path =
        |label: &str| if at.is_empty() { label.to_owned() } else { format!("{at}, {label}") };
    let index = |all: &Labelled<'_>| -> BTreeMap<String, usize> {
        all.iter().enumerate().map(|(place, (label, _))| (label.clone(), place)).collect()
    };
    let (was, is) = (index(before), index(after));
    for (label, gone) in before.iter().filter(|(label, _)| !is.contains_key(label)) {
        found.push(Difference { at: path(label), change: Change::Removed(fields(gone)) });
    }
    let places: Vec<usize> =
        after.iter().filter_map(|(label, _)| was.get(label).copied()).collect();
    let in_order = longest_rise(&places);
    for (label, element) in after {
        let here = was.get(label).and_then(|place| Some((place, before.get(*place)?)));
        let Some((place, (_, before))) = here else {
            found.push(Difference { at: path(label), change: Change::Added(fields(element)) });
            continue;
        };
        compare(&path(label), before, element, found);
        if !in_order.contains(place) {
            found.push(Difference { at: path(label), change: Change::Moved });
        }
    }
}

/// The most of these that stand in rising order: the fewest others have moved.
fn longest_rise(places: &[usize]) -> BTreeSet<usize> {
    // For each length, the smallest end of a rise of it.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: BTreeMap<usize, usize> = BTreeMap::new();
    for place in places {
        let length = ends.partition_point(|end| end < place);
        if let Some(end) = length.checked_sub(1).and_then(|last| ends.get(last)) {
            before.insert(*place, *end);
        }
        match ends.get_mut(length) {
            Some(end) => *end = *place,
            None => ends.push(*place),
        }
    }
    let last = ends.last().copied();
    core::iter::successors(last, |place| before.get(place).copied()).collect()
}

/// By what tells it from its like, or else by its number.
fn labelled<'e>(element: &'e Element<'e>) -> Labelled<'e> {
    const KEYS: [&str; 8] =
        ["id", "activity", "name", "zone", "resource", "bit", "timeline", "variable"];
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let label = |child: &'e Element<'e>| {
        let key = KEYS.iter().find_map(|key| child.attribute(key));
        let label = key
            .map_or_else(|| child.name.to_string(), |key| format!("{} {}", child.name, key.value));
        let number = seen.entry(label.clone()).or_default();
        *number += 1;
        let label = match (key, *number) {
            (Some(_), 1) => label,
            (_, number) => format!("{label} #{number}"),
        };
        (label, child)
    };
    element.children.iter().map(label).collect()
}

fn fields(element: &Element<'_>) -> String {
    let own = element.attributes.iter().map(|one| format!("{}=\"{}\"", one.name, one.value));
    let within = element.children.iter().map(|child| format!("<{} {}>", child.name, fields(child)));
    own.chain(within).collect::<Vec<_>>().join(" ")
}
