//! A state from its elements.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Report, Wrong};
use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::file::fields::Fields;
use crate::file::names::Names;
use crate::file::read::{Placed, used_bit, version};
use crate::file::schema::{self, Known};
use crate::file::value;
use crate::file::words::{self, MODES, OUTCOMES};
use crate::file::xml::Element;
use crate::plan::{ActivityId, Outcome};
use crate::state::{Ended, Mode, Running, State, Window};
use crate::units::Bytes;

/// Reads a state; tells what is wrong with it. `None`: of another version.
pub(in crate::file) fn state<'e>(
    root: &'e Element<'e>,
    names: &Names<'_>,
    report: &mut Report<'_>,
) -> Option<Placed<'e, State, ()>> {
    let mut fields = Fields::new(root, &schema::STATE, names, report);
    version(&mut fields).then(|| {
        let value = read(&mut fields);
        Placed { value, places: (), root, good: fields.good() }
    })
}

fn read(fields: &mut Fields<'_, '_, '_, '_>) -> State {
    let mut activities = BTreeMap::new();
    State {
        now: fields.time("now"),
        mode: fields.need("mode", Mode::Asleep, |text| words::read(text, &MODES)),
        mode_since: fields.time("mode_since"),
        charge: fields.need("charge", Microjoules::ZERO, value::energy),
        capacity: fields.need("capacity", Microjoules::ZERO, value::energy),
        heating: map(fields, &schema::HEATING, |fields| {
            let names = fields.names;
            let zone = fields.need("zone", String::new(), |text| names.zone(text));
            (zone, fields.time("since"))
        }),
        cold: cold(fields),
        variables: map(fields, &schema::VARIABLE, |fields| {
            (fields.need("name", String::new(), value::name), number(fields))
        }),
        timelines: map(fields, &schema::VALUE, |fields| {
            let names = fields.names;
            (fields.need("name", String::new(), |text| names.timeline(text)), number(fields))
        }),
        ended: ended(fields, &mut activities),
        running: running(fields, &mut activities),
        windows: windows(fields),
    }
}

fn number(fields: &mut Fields<'_, '_, '_, '_>) -> i64 {
    fields.need("value", 0, value::number)
}

/// What elements of this kind say, by a name that each has alone.
fn map<T>(
    fields: &mut Fields<'_, '_, '_, '_>,
    known: &'static Known,
    read: impl Fn(&mut Fields<'_, '_, '_, '_>) -> (String, T),
) -> BTreeMap<String, T> {
    let mut map = BTreeMap::new();
    let mut places: BTreeMap<String, &Element<'_>> = BTreeMap::new();
    let key = known.attributes.first().copied().unwrap_or_default();
    for element in fields.children(known) {
        let mut fields = fields.within(element, known);
        let (name, value) = read(&mut fields);
        match places.get(&name) {
            Some(first) if !name.is_empty() => fields.twice(key, "the name", first.span(key)),
            _ => {
                places.insert(name.clone(), element);
                map.insert(name, value);
            }
        }
    }
    map
}

fn cold(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<String> {
    let mut cold: Vec<String> = Vec::new();
    for element in fields.children(&schema::COLD) {
        let mut fields = fields.within(element, &schema::COLD);
        let names = fields.names;
        let zone = fields.need("zone", String::new(), |text| names.zone(text));
        if cold.contains(&zone) && fields.good() {
            fields.twice("zone", "the zone", element.span("zone"));
        }
        cold.push(zone);
    }
    cold
}

/// The activity that an element tells of: no other one does.
fn activity<'e>(
    fields: &mut Fields<'e, '_, '_, '_>,
    told: &mut BTreeMap<ActivityId, &'e Element<'e>>,
) -> ActivityId {
    let element = fields.element;
    let id = fields.need("activity", ActivityId::FIRST, value::activity);
    match told.get(&id) {
        _ if !fields.good() => {}
        Some(first) => fields.twice("activity", &id.to_string(), first.span("activity")),
        None => {
            told.insert(id, element);
        }
    }
    id
}

fn ended<'e>(
    fields: &mut Fields<'e, '_, '_, '_>,
    told: &mut BTreeMap<ActivityId, &'e Element<'e>>,
) -> Vec<Ended> {
    let mut all = Vec::new();
    for element in fields.children(&schema::ENDED) {
        let mut fields = fields.within(element, &schema::ENDED);
        let ended = Ended {
            id: activity(&mut fields, told),
            outcome: fields
                .need("outcome", Outcome::Succeeded, |text| words::read(text, &OUTCOMES)),
            started: fields.time_if("started"),
            ended: fields.time("ended"),
            data: fields.or("data", Bytes::ZERO, value::data),
        };
        if ended.started.is_some_and(|started| started > ended.ended) && fields.good() {
            let wrong = Wrong::new(Rule::Window, "it ended before it started");
            fields.error(element.span("ended"), "ended", wrong.expected("not before started"));
        }
        all.push(ended);
    }
    all
}

fn running<'e>(
    fields: &mut Fields<'e, '_, '_, '_>,
    told: &mut BTreeMap<ActivityId, &'e Element<'e>>,
) -> Vec<Running> {
    let mut all = Vec::new();
    for element in fields.children(&schema::RUNNING) {
        let mut fields = fields.within(element, &schema::RUNNING);
        let running = Running {
            id: activity(&mut fields, told),
            started: fields.time("started"),
            ends: fields.time("ends"),
            cutoff: fields.time("cutoff"),
            paused: fields.time_if("paused"),
            data: fields.or("data", Bytes::ZERO, value::data),
        };
        if running.ends < running.started && fields.good() {
            let wrong = Wrong::new(Rule::Window, "it would end before it started");
            fields.error(element.span("ends"), "ends", wrong.expected("not before started"));
        }
        all.push(running);
    }
    all
}

fn windows(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<Window> {
    let mut windows = Vec::new();
    for element in fields.children(&schema::WINDOW) {
        let mut fields = fields.within(element, &schema::WINDOW);
        let window = Window {
            name: fields.need("name", String::new(), value::name),
            start: fields.time("start"),
            end: fields.time("end"),
            awake: fields.or("awake", false, value::yes_or_no),
            marginal: fields.or("marginal", Milliwatts::ZERO, value::power),
            peak: fields.or("peak", Milliwatts::ZERO, value::power),
            data: fields.or("data", Bytes::ZERO, value::data),
            engines: fields.or("engines", 0, value::count),
            resources: window_uses(&mut fields),
        };
        if window.end < window.start && fields.good() {
            let wrong = Wrong::new(Rule::Window, "the window ends before it begins");
            fields.error(element.span("end"), "end", wrong.expected("not before start"));
        }
        windows.push(window);
    }
    windows
}

fn window_uses(fields: &mut Fields<'_, '_, '_, '_>) -> Categories {
    let mut resources = Categories::NONE;
    for element in fields.children(&schema::WINDOW_USES) {
        let mut fields = fields.within(element, &schema::WINDOW_USES);
        let Some(how) = fields.one_of(schema::WINDOW_USES.attributes) else { continue };
        let bit = used_bit(&mut fields, how);
        if resources.overlaps(bit) {
            fields.twice(how, "the resource", element.span(how));
        }
        resources = resources.union(bit);
    }
    resources
}
