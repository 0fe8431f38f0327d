//! What names mean: resources, zones and timelines of the parameters, and the
//! day by which times of day are read.

use core::cell::Cell;

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Wrong, nearest, shown};

use crate::file::value;
use crate::parameters::{Day, Parameters, TimelineSpec};

/// The parameters, if there are any.
#[derive(Debug)]
pub(crate) struct Names<'p> {
    pub(crate) parameters: Option<&'p Parameters>,
    /// Something was read as if it were known.
    pub(crate) assumed: Cell<bool>,
    /// Somebody was told that resources cannot be looked up.
    told: Cell<bool>,
}

impl<'p> Names<'p> {
    pub(crate) const fn new(parameters: Option<&'p Parameters>) -> Self {
        Self { parameters, assumed: Cell::new(false), told: Cell::new(false) }
    }

    /// Whether an error says already that there are no parameters.
    pub(crate) fn told(&self) -> bool {
        self.told.get()
    }

    pub(crate) fn day(&self) -> Day {
        self.parameters.map_or(Day::SOL, |parameters| parameters.day)
    }

    /// The bit of a resource's name; `None`: nobody can know it, and this was
    /// told once.
    pub(crate) fn resource(&self, text: &str) -> Result<Option<u8>, Wrong> {
        let name = value::name(text)?;
        let Some(parameters) = self.parameters else {
            if self.told.replace(true) {
                return Ok(None);
            }
            let message =
                format!("nobody knows here which bits {} and other names are", shown(text));
            let wrong = Wrong::new(Rule::UnknownName, message).expected("the number of a bit");
            return Err(wrong.help("name the parameters' file, too"));
        };
        let names = parameters.resources.keys();
        let bit = parameters.resources.get(&name).copied();
        bit.map(Some).ok_or_else(|| unknown("resource", text, names))
    }

    /// A zone's name, which must be one that is known.
    pub(crate) fn zone(&self, text: &str) -> Result<String, Wrong> {
        let name = value::name(text)?;
        let Some(parameters) = self.parameters else { return Ok(self.assume(name)) };
        let mut names = parameters.zones.iter().map(|zone| &zone.name);
        match names.any(|known| *known == name) {
            true => Ok(name),
            false => Err(unknown("zone", text, parameters.zones.iter().map(|zone| &zone.name))),
        }
    }

    /// A timeline's name, which must be one that is known.
    pub(crate) fn timeline(&self, text: &str) -> Result<String, Wrong> {
        let name = value::name(text)?;
        let Some(parameters) = self.parameters else { return Ok(self.assume(name)) };
        match self.timeline_of(&name) {
            Some(_) => Ok(name),
            None => {
                Err(unknown("timeline", text, parameters.timelines.iter().map(|one| &one.name)))
            }
        }
    }

    pub(crate) fn timeline_of(&self, name: &str) -> Option<&'p TimelineSpec> {
        self.parameters?.timelines.iter().find(|timeline| timeline.name == name)
    }

    /// A name of this bit.
    pub(crate) fn resource_name(&self, bit: u8) -> Option<&'p str> {
        let mut names = self.parameters?.resources.iter();
        names.find(|(_, known)| **known == bit).map(|(name, _)| name.as_str())
    }

    fn assume(&self, name: String) -> String {
        self.assumed.set(true);
        name
    }
}

fn unknown<'a>(what: &str, text: &str, known: impl Iterator<Item = &'a String> + Clone) -> Wrong {
    let message = format!("the parameters have no {what} {}", shown(text));
    let expected: Vec<_> = known.clone().take(12).map(String::as_str).collect();
    let wrong = Wrong::new(Rule::UnknownName, message).expected(match expected.is_empty() {
        true => format!("no {what}, since the parameters have none"),
        false => format!("one that they have: {}", expected.join(", ")),
    });
    match nearest(text, known.map(String::as_str)) {
        Some(near) => wrong.help(format!("did you mean {near}?")),
        None => wrong,
    }
}
