//! Elements from models, and text from elements.

mod parameters;
mod plan;
mod state;

use std::borrow::Cow;
use std::io;

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use crate::file::Document;
use crate::file::names::Names;
use crate::file::schema::{Known, USES};
use crate::file::xml::{Attribute, Element};
use crate::file::{show, times};
use crate::parameters::Load;
use crate::units::Time;

/// The elements of a document: with names and times of day where there are
/// parameters, with bits and seconds where there are none. Either is read again
/// as the same.
pub(super) fn element(document: &Document, names: &Names<'_>) -> Element<'static> {
    match document {
        Document::Plan(plan) => plan::plan(plan, names),
        Document::Parameters(parameters) => parameters::parameters(parameters),
        Document::State(state) => state::state(state, names),
    }
}

/// The text of an element and all that is in it.
pub(super) fn text(root: &Element<'_>) -> String {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    // Writing into memory cannot fail.
    let _ = writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    let _ = put(root, &mut writer);
    let mut text = String::from_utf8(writer.into_inner()).unwrap_or_default();
    text.push('\n');
    text
}

/// So many attributes stand on a line.
const ON_A_LINE: usize = 7;

/// No element is nested deeply enough for this to be a worry.
fn put(element: &Element<'_>, writer: &mut Writer<Vec<u8>>) -> io::Result<()> {
    let mut tag = writer.create_element(&*element.name);
    for (number, one) in element.attributes.iter().enumerate() {
        let full = number > 0 && number % ON_A_LINE == 0;
        tag = if full { tag.new_line() } else { tag };
        tag = tag.with_attribute((&*one.name, &*one.value));
    }
    if element.children.is_empty() {
        return tag.write_empty().map(|_| ());
    }
    let children = |writer: &mut Writer<Vec<u8>>| {
        element.children.iter().try_for_each(|child| put(child, writer))
    };
    tag.write_inner_content(children).map(|_| ())
}

/// An element that is being made.
struct Build<'n, 'p> {
    element: Element<'static>,
    names: &'n Names<'p>,
}

impl<'n, 'p> Build<'n, 'p> {
    fn new(known: &Known, names: &'n Names<'p>) -> Self {
        let element = Element { name: Cow::Borrowed(known.name), ..Element::default() };
        Self { element, names }
    }

    fn set(&mut self, name: &'static str, value: impl Into<String>) -> &mut Self {
        self.element.attributes.push(Attribute {
            name: Cow::Borrowed(name),
            at: 0..0,
            value: Cow::Owned(value.into()),
            value_at: 0..0,
        });
        self
    }

    fn set_if(&mut self, name: &'static str, value: Option<impl Into<String>>) -> &mut Self {
        if let Some(value) = value {
            self.set(name, value);
        }
        self
    }

    /// Sets a value where it is not the one that is read when nothing stands
    /// there.
    fn unless<T: PartialEq>(
        &mut self,
        default: T,
        name: &'static str,
        value: T,
        show: impl FnOnce(T) -> String,
    ) -> &mut Self {
        self.set_if(name, (value != default).then(|| show(value)))
    }

    fn time(&mut self, name: &'static str, at: Time) -> &mut Self {
        self.time_if(name, Some(at))
    }

    fn time_if(&mut self, name: &'static str, at: Option<Time>) -> &mut Self {
        let day = self.names.parameters.map(|parameters| parameters.day);
        self.set_if(name, at.map(|at| times::shown_time(at, day)))
    }

    fn load(&mut self, load: Load) -> &mut Self {
        self.unless(Milliwatts::ZERO, "marginal", load.marginal, show::power);
        self.unless(Milliwatts::ZERO, "peak", load.peak, show::power)
    }

    fn limits(&mut self, min: i64, max: i64) -> &mut Self {
        self.unless(i64::MIN, "min", min, |min| min.to_string());
        self.unless(i64::MAX, "max", max, |max| max.to_string())
    }

    /// A new element in this one.
    fn add(&mut self, known: &Known, fill: impl FnOnce(&mut Self)) {
        let mut child = Self::new(known, self.names);
        fill(&mut child);
        self.element.children.push(child.element);
    }

    /// One element for each resource usage bit.
    fn uses(&mut self, resources: Categories) {
        for bit in (0..128_u8).filter(|bit| resources.mask() >> bit & 1 == 1) {
            let name = self.names.resource_name(bit).map(str::to_owned);
            self.add(&USES, |uses| {
                match name {
                    Some(name) => uses.set("resource", name),
                    None => uses.set("bit", bit.to_string()),
                };
            });
        }
    }
}
