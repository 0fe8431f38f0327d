//! An XML file as a tree of elements, each with its place. Text, document
//! types and processing instructions mean nothing here and are refused.

use core::ops::Range;
use std::borrow::Cow;

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Report, Wrong, shown};
use quick_xml::escape::unescape;
use quick_xml::events::attributes::{AttrError, Attribute as Raw};
use quick_xml::events::{BytesDecl, BytesStart, Event};
use quick_xml::{Error, Reader};

/// Nothing that is read here is nested deeper.
const DEPTH: usize = 8;

/// An element and all that is in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Element<'s> {
    pub(crate) name: Cow<'s, str>,
    /// Where its name stands.
    pub(crate) at: Range<usize>,
    /// In the file's order, each name once.
    pub(crate) attributes: Vec<Attribute<'s>>,
    pub(crate) children: Vec<Self>,
}

/// An attribute of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Attribute<'s> {
    pub(crate) name: Cow<'s, str>,
    pub(crate) at: Range<usize>,
    pub(crate) value: Cow<'s, str>,
    pub(crate) value_at: Range<usize>,
}

impl Element<'_> {
    pub(crate) fn attribute(&self, name: &str) -> Option<&Attribute<'_>> {
        self.attributes.iter().find(|one| one.name == name)
    }

    /// The element of this name and number in it; itself where there is none.
    pub(crate) fn nth(&self, name: &str, number: usize) -> &Self {
        self.children.iter().filter(|child| child.name == name).nth(number).unwrap_or(self)
    }

    /// Where the value of an attribute stands, or the element where it has none.
    pub(crate) fn span(&self, name: &str) -> Range<usize> {
        self.attribute(name).map_or_else(|| self.at.clone(), |one| one.value_at.clone())
    }
}

/// The root element, if there is one; tells what is wrong.
pub(crate) fn parse<'s>(text: &'s str, report: &mut Report<'s>) -> Option<Element<'s>> {
    let mut tree = Tree { text, report, open: Vec::new(), root: None, too_deep: false };
    let mut reader = Reader::from_str(text);
    reader.config_mut().check_comments = true;
    while !tree.too_deep {
        let at = position(reader.buffer_position());
        match reader.read_event() {
            Ok(Event::Eof) => break,
            Ok(event) => tree.take(at..position(reader.buffer_position()), &event),
            Err(error) => {
                // What follows a broken tag is anybody's guess.
                tree.broken(position(reader.error_position()), &error);
                return None;
            }
        }
    }
    tree.close_all();
    tree.root
}

fn position(offset: u64) -> usize {
    usize::try_from(offset).unwrap_or(usize::MAX)
}

/// A tree that is being built.
struct Tree<'s, 'r> {
    text: &'s str,
    report: &'r mut Report<'s>,
    open: Vec<Element<'s>>,
    root: Option<Element<'s>>,
    too_deep: bool,
}

impl<'s> Tree<'s, '_> {
    fn take(&mut self, at: Range<usize>, event: &Event<'_>) {
        match event {
            Event::Start(tag) => {
                let element = self.element(&at, tag);
                if self.open.len() == DEPTH {
                    let message = format!("elements are nested deeper than {DEPTH}");
                    self.wrong(element.at.clone(), Wrong::new(Rule::Unknown, message));
                    self.too_deep = true;
                }
                self.open.push(element);
            }
            Event::Empty(tag) => {
                let element = self.element(&at, tag);
                self.close(element);
            }
            Event::End(_) => {
                if let Some(element) = self.open.pop() {
                    self.close(element);
                }
            }
            Event::Decl(declaration) => self.declaration(at, declaration),
            Event::Comment(_) | Event::Eof => {}
            Event::Text(text) if text.chars().all(char::is_whitespace) => {}
            Event::Text(_) | Event::CData(_) | Event::GeneralRef(_) => self.text(at),
            Event::DocType(_) | Event::PI(_) => {
                let message = "nothing here needs a document type or an instruction";
                self.wrong(at, Wrong::new(Rule::Syntax, message).expected("elements"));
            }
        }
    }

    fn text(&mut self, at: Range<usize>) {
        let stands = self.text.get(at.clone()).unwrap_or_default();
        let from = at.start + stands.len() - stands.trim_start().len();
        let message = format!("{} stands outside of every element's tag", shown(stands.trim()));
        let wrong = Wrong::new(Rule::Unknown, message).expected("elements with attributes");
        self.wrong(from..from + stands.trim().len(), wrong);
    }

    fn declaration(&mut self, at: Range<usize>, declaration: &BytesDecl<'_>) {
        if let Some(Ok(encoding)) = declaration.encoding()
            && !encoding.eq_ignore_ascii_case("utf-8")
        {
            let message = format!("the file says that it is in {}", shown(&encoding));
            self.wrong(at, Wrong::new(Rule::Encoding, message).expected("UTF-8"));
        }
    }

    fn element(&mut self, at: &Range<usize>, tag: &BytesStart<'_>) -> Element<'s> {
        // Behind the `<`.
        let begin = at.start + 1;
        let name_at = begin..begin + tag.name().as_ref().len();
        let mut element = Element { name: self.slice(&name_at), at: name_at, ..Element::default() };
        for raw in tag.attributes().with_checks(false) {
            match raw {
                Ok(raw) => self.attribute(&mut element, begin, tag, &raw),
                Err(error) => self.bad_attribute(begin, at.end, &error),
            }
        }
        element
    }

    fn attribute(
        &mut self,
        element: &mut Element<'s>,
        begin: usize,
        tag: &BytesStart<'_>,
        raw: &Raw<'_>,
    ) {
        // What is borrowed from the tag stands at this place in the file.
        let place = |part: &str| {
            let offset = part.as_ptr().addr().saturating_sub(tag.as_ptr().addr());
            begin + offset..begin + offset + part.len()
        };
        let (at, value_at) = (place(raw.key.0), place(&raw.value));
        let name = self.slice(&at);
        if let Some(first) = element.attribute(&name) {
            let also = (first.at.clone(), "here first".to_owned());
            let message = format!("{} is given twice", shown(&name));
            let wrong = Wrong::new(Rule::Duplicate, message).expected("each attribute once");
            self.report.error_with(at, &element.name, wrong, also);
            return;
        }
        match unescape(self.text.get(value_at.clone()).unwrap_or_default()) {
            Ok(value) => element.attributes.push(Attribute { name, at, value, value_at }),
            Err(error) => self.wrong(value_at, Wrong::new(Rule::Syntax, error.to_string())),
        }
    }

    fn bad_attribute(&mut self, begin: usize, end: usize, error: &AttrError) {
        let (offset, what, expected) = match *error {
            AttrError::ExpectedEq(at) => {
                (at, "there is no = behind an attribute", "name=\"value\"")
            }
            AttrError::ExpectedValue(at) => (at, "there is nothing behind the =", "name=\"value\""),
            AttrError::UnquotedValue(at) => (at, "a value is not in quotes", "name=\"value\""),
            AttrError::ExpectedQuote(at, _) => {
                (at, "a quote is not closed", "the same quote again")
            }
            AttrError::Duplicated(at, _) => (at, "an attribute is given twice", "each once"),
        };
        let at = (begin + offset).min(end);
        self.wrong(at..at, Wrong::new(Rule::Syntax, what).expected(expected));
    }

    fn close(&mut self, element: Element<'s>) {
        match self.open.last_mut() {
            Some(parent) => parent.children.push(element),
            None if self.root.is_none() => self.root = Some(element),
            None => {
                let message = format!("there is a second element <{}>", element.name);
                let wrong = Wrong::new(Rule::Duplicate, message).expected("one outermost element");
                self.wrong(element.at, wrong);
            }
        }
    }

    fn close_all(&mut self) {
        if self.too_deep {
            self.root = None;
        } else if let Some(open) = self.open.last() {
            let message = format!("<{}> is not closed", open.name);
            let expected = format!("</{}> at the end of it", open.name);
            let at = open.at.clone();
            self.wrong(at, Wrong::new(Rule::Syntax, message).expected(expected));
            self.root = None;
        } else if self.root.is_none() && self.report.found.is_empty() {
            let wrong = Wrong::new(Rule::Missing, "there is no element").expected(super::ROOTS);
            self.wrong(0..0, wrong);
        }
    }

    fn broken(&mut self, at: usize, error: &Error) {
        let wrong = Wrong::new(Rule::Syntax, error.to_string());
        self.wrong(at..at, wrong.expected("well-formed XML"));
    }

    fn wrong(&mut self, at: Range<usize>, wrong: Wrong) {
        self.report.error(at, "", wrong);
    }

    fn slice(&self, at: &Range<usize>) -> Cow<'s, str> {
        Cow::Borrowed(self.text.get(at.clone()).unwrap_or_default())
    }
}
