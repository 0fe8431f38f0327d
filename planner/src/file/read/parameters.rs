//! Parameters from their elements.

use std::collections::BTreeMap;

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Report, Wrong};
use faregate_tickets::amount::Milliwatts;

use crate::file::fields::Fields;
use crate::file::names::Names;
use crate::file::read::{Placed, limits, load, version};
use crate::file::schema::{self, Known};
use crate::file::words::{self, TIMELINES};
use crate::file::xml::Element;
use crate::file::{times, value};
use crate::parameters::{
    Day, Load, Parameters, Phase, PreheatRow, TimelineKind, TimelineSpec, Zone,
};
use crate::units::{Ppm, Span, Time};

/// Reads parameters; tells what is wrong with them. `None`: of another version.
pub(in crate::file) fn parameters<'e>(
    root: &'e Element<'e>,
    report: &mut Report<'_>,
) -> Option<Placed<'e, Parameters, ()>> {
    let names = Names::new(None);
    let mut fields = Fields::new(root, &schema::PARAMETERS, &names, report);
    version(&mut fields).then(|| {
        let value = read(&mut fields);
        Placed { value, places: (), root, good: fields.good() }
    })
}

fn read(fields: &mut Fields<'_, '_, '_, '_>) -> Parameters {
    let awake = only(fields, &schema::AWAKE).map(|element| fields.within(element, &schema::AWAKE));
    let awake = awake.map_or_else(Load::default, |mut fields| load(&mut fields));
    Parameters {
        mandatory_from: fields.need("mandatory_from", 0, value::count),
        soft_min_soc: fields.need("soft_min_soc", Ppm::ZERO, value::fraction),
        hard_min_soc: fields.need("hard_min_soc", Ppm::ZERO, value::fraction),
        max_soc: fields.need("max_soc", Ppm::ZERO, value::fraction),
        peak_limit: power(fields, "peak_limit"),
        engines: fields.need("engines", 0, value::count),
        rtg: power(fields, "rtg"),
        base: power(fields, "base"),
        awake,
        wakeup: phase(fields, &schema::WAKEUP),
        shutdown: phase(fields, &schema::SHUTDOWN),
        min_awake: span(fields, "min_awake"),
        min_sleep: span(fields, "min_sleep"),
        day: day(fields),
        zones: zones(fields),
        timelines: timelines(fields),
        resources: resources(fields),
        commit: span(fields, "commit"),
        expansion_grace: span(fields, "expansion_grace"),
        handover_tolerance: span(fields, "handover_tolerance"),
        soft_samples: fields.need("soft_samples", 1, value::count),
    }
}

fn power(fields: &mut Fields<'_, '_, '_, '_>, name: &'static str) -> Milliwatts {
    fields.need(name, Milliwatts::ZERO, value::power)
}

fn span(fields: &mut Fields<'_, '_, '_, '_>, name: &'static str) -> Span {
    fields.span(name)
}

/// The one element of this kind, which must be there.
fn only<'e>(fields: &mut Fields<'e, '_, '_, '_>, known: &'static Known) -> Option<&'e Element<'e>> {
    let child = fields.child(known);
    if child.is_none() {
        let wrong = Wrong::new(Rule::Missing, format!("there is no <{}>", known.name));
        let at = fields.element.at.clone();
        fields.error(at, known.name, wrong.expected("one"));
    }
    child
}

fn phase(fields: &mut Fields<'_, '_, '_, '_>, known: &'static Known) -> Phase {
    let Some(element) = only(fields, known) else { return Phase::default() };
    let mut fields = fields.within(element, known);
    Phase { duration: span(&mut fields, "duration"), load: load(&mut fields) }
}

/// Mars's, with a midnight at the origin, where nobody says otherwise.
fn day(fields: &mut Fields<'_, '_, '_, '_>) -> Day {
    let Some(element) = fields.child(&schema::DAY) else { return Day::SOL };
    let mut fields = fields.within(element, &schema::DAY);
    let length = fields.or("length", Day::SOL.length, value::span);
    if length == Span::ZERO && fields.good() {
        let wrong = Wrong::new(Rule::Range, "the day has no length");
        fields.error(element.span("length"), "length", wrong.expected("more than 0 ms"));
    }
    // A time of day means nothing yet.
    let midnight = fields.or("midnight", Time::ZERO, |text| match times::needs_a_day(text) {
        true => times::time_of_day(text).map(|since| Time::ZERO.after(since)),
        false => times::time(text, Day::SOL),
    });
    Day { length, midnight }
}

fn zones(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<Zone> {
    let mut zones: Vec<Zone> = Vec::new();
    let mut places = BTreeMap::new();
    for element in fields.children(&schema::ZONE) {
        let mut fields = fields.within(element, &schema::ZONE);
        let name = name(&mut fields, &mut places);
        let load = load(&mut fields);
        let mut table = Vec::new();
        for row in fields.children(&schema::PREHEAT) {
            let mut fields = fields.within(row, &schema::PREHEAT);
            table.push(PreheatRow {
                from: fields.need("from", Span::ZERO, times::time_of_day),
                duration: span(&mut fields, "duration"),
            });
        }
        zones.push(Zone { name, load, table });
    }
    zones
}

/// A name that no other element of its kind has.
fn name<'e>(
    fields: &mut Fields<'e, '_, '_, '_>,
    places: &mut BTreeMap<String, &'e Element<'e>>,
) -> String {
    let element = fields.element;
    let name = fields.need("name", String::new(), value::name);
    match places.get(&name) {
        Some(first) if !name.is_empty() => {
            fields.twice("name", "the name", first.span("name"));
        }
        _ => {
            places.insert(name.clone(), element);
        }
    }
    name
}

fn timelines(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<TimelineSpec> {
    let mut timelines = Vec::new();
    let mut places = BTreeMap::new();
    for element in fields.children(&schema::TIMELINE) {
        let mut fields = fields.within(element, &schema::TIMELINE);
        let (min, max) = limits(&mut fields);
        timelines.push(TimelineSpec {
            name: name(&mut fields, &mut places),
            kind: fields.need("kind", TimelineKind::State, |text| words::read(text, &TIMELINES)),
            initial: fields.need("initial", 0, value::number),
            min,
            max,
        });
    }
    timelines
}

fn resources(fields: &mut Fields<'_, '_, '_, '_>) -> BTreeMap<String, u8> {
    let mut resources = BTreeMap::new();
    let mut places = BTreeMap::new();
    let mut bits: BTreeMap<u8, &Element<'_>> = BTreeMap::new();
    for element in fields.children(&schema::RESOURCE) {
        let mut fields = fields.within(element, &schema::RESOURCE);
        let name = name(&mut fields, &mut places);
        let Some(bit) = Some(fields.need("bit", 0, value::bit)).filter(|_| fields.good()) else {
            continue;
        };
        match bits.get(&bit) {
            Some(first) => fields.twice("bit", &format!("bit {bit}"), first.span("bit")),
            None => {
                bits.insert(bit, element);
                resources.insert(name, bit);
            }
        }
    }
    resources
}
