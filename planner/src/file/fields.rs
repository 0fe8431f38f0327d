//! An element that is being read: which attributes it has, and what is wrong
//! with their values.

use core::ops::Range;

use faregate_scheduler::format::reading::{Report, Wrong, nearest, shown};
use faregate_scheduler::format::{Diagnostic, Rule};

use crate::file::names::Names;
use crate::file::schema::Known;
use crate::file::times;
use crate::file::value;
use crate::file::xml::Element;
use crate::units::{Span, Time};

/// An element, what is known of it, and where mistakes are told.
pub(crate) struct Fields<'e, 'r, 's, 'p> {
    pub(crate) element: &'e Element<'e>,
    known: &'static Known,
    pub(crate) names: &'r Names<'p>,
    report: &'r mut Report<'s>,
    before: usize,
}

impl<'e, 'r, 's, 'p> Fields<'e, 'r, 's, 'p> {
    /// Tells at once of what nobody knows.
    pub(crate) fn new(
        element: &'e Element<'e>,
        known: &'static Known,
        names: &'r Names<'p>,
        report: &'r mut Report<'s>,
    ) -> Self {
        let before = report.found.len();
        let mut fields = Self { element, known, names, report, before };
        fields.refuse_unknown();
        fields
    }

    fn refuse_unknown(&mut self) {
        for one in &self.element.attributes {
            // Editors are told by these where the schema is.
            let of_editors = one.name.starts_with("xmlns") || one.name.starts_with("xsi:");
            if !self.known.attributes.contains(&&*one.name) && !of_editors {
                let known = self.known.attributes;
                self.error(one.at.clone(), &one.name, unknown("attribute", &one.name, known));
            }
        }
        let known: Vec<_> = self.known.children.iter().map(|known| known.name).collect();
        for child in &self.element.children {
            if !known.contains(&&*child.name) {
                let wrong = unknown("element", &child.name, &known);
                self.error(child.at.clone(), "", wrong);
            }
        }
    }

    /// Whether nothing is wrong so far.
    pub(crate) fn good(&self) -> bool {
        !self.report.found.iter().skip(self.before).any(Diagnostic::is_error)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.element.attribute(name).is_some()
    }

    /// Reads a value, if it is there; tells what is wrong with it.
    pub(crate) fn read<T>(
        &mut self,
        name: &'static str,
        read: impl FnOnce(&str) -> Result<T, Wrong>,
    ) -> Option<T> {
        let attribute = self.element.attribute(name)?;
        let value = read(&attribute.value);
        let field = self.field(name);
        self.report.take(attribute.value_at.clone(), &field, value)
    }

    /// Reads a value, or takes this one where there is none.
    pub(crate) fn or<T>(
        &mut self,
        name: &'static str,
        default: T,
        read: impl FnOnce(&str) -> Result<T, Wrong>,
    ) -> T {
        self.read(name, read).unwrap_or(default)
    }

    /// Reads a value that must be there. What stands in for a bad one is never
    /// looked at, since the file is refused.
    pub(crate) fn need<T>(
        &mut self,
        name: &'static str,
        stand_in: T,
        read: impl FnOnce(&str) -> Result<T, Wrong>,
    ) -> T {
        if !self.has(name) {
            let message = format!("<{}> has no {name}", self.element.name);
            let wrong = Wrong::new(Rule::Missing, message).expected(format!("{name}=\"...\""));
            self.error(self.element.at.clone(), name, wrong);
        }
        self.read(name, read).unwrap_or(stand_in)
    }

    /// A span that must be there. One without a unit is in seconds, and it is
    /// said that it was read so: minutes may have been meant.
    pub(crate) fn span(&mut self, name: &'static str) -> Span {
        let span = self.need(name, Span::ZERO, value::span);
        let bare = self.element.attribute(name).filter(|one| value::has_no_unit(&one.value));
        if let Some(one) = bare
            && span > Span::ZERO
        {
            let text = one.value.trim();
            let wrong =
                Wrong::new(Rule::Assumed, format!("{text} without a unit is read as seconds"));
            let field = self.field(name);
            self.report.warn(
                one.value_at.clone(),
                &field,
                wrong.help(format!("write \"{text} s\", or min or h if that is what is meant")),
            );
        }
        span
    }

    /// An instant that must be there.
    pub(crate) fn time(&mut self, name: &'static str) -> Time {
        let names = self.names;
        self.need(name, Time::ZERO, |text| read_time(text, names))
    }

    /// An instant, if it is there.
    pub(crate) fn time_if(&mut self, name: &'static str) -> Option<Time> {
        let names = self.names;
        self.read(name, |text| read_time(text, names))
    }

    /// Which of these is there; tells where it is not exactly one.
    pub(crate) fn one_of(&mut self, names: &[&'static str]) -> Option<&'static str> {
        let mut there: Vec<_> = names.iter().copied().filter(|name| self.has(name)).collect();
        there.sort_by_key(|name| self.element.span(name).start);
        match (there.first().copied(), there.get(1).copied()) {
            (Some(only), None) => Some(only),
            (None, _) => {
                let message = format!("<{}> says nothing", self.element.name);
                let wrong = Wrong::new(Rule::Missing, message);
                let wrong = wrong.expected(format!("one of {}", names.join(", ")));
                self.error(self.element.at.clone(), "", wrong);
                None
            }
            (Some(first), Some(second)) => {
                let message = format!("<{}> has {first} and {second}", self.element.name);
                let wrong = Wrong::new(Rule::Duplicate, message);
                let wrong = wrong.expected(format!("one of {}", names.join(", ")));
                self.error(self.element.span(second), second, wrong);
                None
            }
        }
    }

    /// Elements of this kind in it.
    pub(crate) fn children(
        &self,
        known: &Known,
    ) -> impl Iterator<Item = &'e Element<'e>> + use<'e> {
        let name = known.name;
        self.element.children.iter().filter(move |child| child.name == name)
    }

    /// The only element of this kind in it; tells where there are more.
    pub(crate) fn child(&mut self, known: &Known) -> Option<&'e Element<'e>> {
        let mut children = self.children(known);
        let first = children.next()?;
        for more in children {
            let also = (first.at.clone(), "here first".to_owned());
            let wrong = Wrong::new(Rule::Duplicate, format!("there is a second <{}>", known.name))
                .expected("one");
            self.report.error_with(more.at.clone(), "", wrong, also);
        }
        Some(first)
    }

    /// The same for an element in it.
    pub(crate) fn within<'x>(
        &'x mut self,
        element: &'e Element<'e>,
        known: &'static Known,
    ) -> Fields<'e, 'x, 's, 'p> {
        Fields::new(element, known, self.names, self.report)
    }

    pub(crate) fn error(&mut self, at: Range<usize>, name: &str, wrong: Wrong) {
        let field = self.field(name);
        self.report.error(at, &field, wrong);
    }

    /// Something is there twice.
    pub(crate) fn twice(&mut self, name: &'static str, what: &str, first: Range<usize>) {
        let at = self.element.span(name);
        let wrong = Wrong::new(Rule::Duplicate, format!("{what} is there twice"));
        let field = self.field(name);
        let also = (first, "here first".to_owned());
        self.report.error_with(at, &field, wrong.expected("each once"), also);
    }

    fn field(&self, name: &str) -> String {
        match name {
            "" => self.element.name.to_string(),
            _ => format!("{}.{name}", self.element.name),
        }
    }
}

fn read_time(text: &str, names: &Names<'_>) -> Result<Time, Wrong> {
    if names.parameters.is_none() && times::needs_a_day(text) {
        names.assumed.set(true);
    }
    times::time(text, names.day())
}

fn unknown(what: &str, name: &str, known: &[&str]) -> Wrong {
    let wrong = Wrong::new(Rule::Unknown, format!("there is no {what} {} here", shown(name)));
    let wrong = wrong.expected(match known {
        [] => format!("no {what}"),
        _ => known.join(", "),
    });
    match nearest(name, known.iter().copied()) {
        Some(near) => wrong.help(format!("did you mean {near}?")),
        None => wrong,
    }
}
