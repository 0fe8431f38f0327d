//! An activity from its elements.

use faregate_agents::Categories;
use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::Wrong;
use faregate_tickets::amount::Milliwatts;

use crate::file::fields::Fields;
use crate::file::read::{limits, used_bit};
use crate::file::schema;
use crate::file::value;
use crate::file::words::{self, TYPES, Type, VARIABLES};
use crate::plan::{
    Activity, ActivityId, Condition, Constraint, Dependency, Effect, Impact, Kind, StartRange,
    Variable,
};
use crate::units::Bytes;

/// Stands in for numbers that cannot be read.
const NOBODY: ActivityId = ActivityId::FIRST;

pub(super) fn activity(fields: &mut Fields<'_, '_, '_, '_>) -> Activity {
    let (resources, zones) = uses(fields);
    Activity {
        id: fields.need("id", NOBODY, value::activity),
        name: fields.read("name", value::name),
        kind: kind(fields),
        sequence: fields.read("sequence", value::name),
        priority: fields.need("priority", 0, value::count),
        value: fields.read("value", value::worth),
        duration: fields.span("duration"),
        marginal: fields.or("marginal", Milliwatts::ZERO, value::power),
        energy: fields.read("energy", value::energy),
        peak: fields.or("peak", Milliwatts::ZERO, value::power),
        data: fields.or("data", Bytes::ZERO, value::data),
        engines: fields.or("engines", 0, value::count),
        starts: starts(fields),
        after: after(fields),
        resources,
        zones,
        conditions: conditions(fields),
        impacts: impacts(fields),
        constraints: constraints(fields),
        group: fields.read("group", value::name),
        pausable: fields.or("pausable", false, value::yes_or_no),
    }
}

fn kind(fields: &mut Fields<'_, '_, '_, '_>) -> Kind {
    let of = match fields.has("type") {
        true => fields.read("type", |text| words::read(text, &TYPES)),
        false => Some(Type::Generic),
    };
    // What belongs to a type that nobody knows is not judged.
    let Some(of) = of else { return Kind::Generic };
    let (kind, uses): (_, &[&str]) = match of {
        Type::Generic => (Kind::Generic, &[]),
        Type::StayAwake => (Kind::StayAwake, &[]),
        Type::Cleanup => (Kind::Cleanup, &[]),
        Type::Expanding => {
            let minimum = fields.span("minimum");
            (Kind::Expanding { minimum }, &["minimum"])
        }
        Type::ManualShutdown => {
            let shutdown = fields.span("shutdown");
            let wakeup = fields.span("wakeup");
            (Kind::ManualShutdown { shutdown, wakeup }, &["shutdown", "wakeup"])
        }
    };
    let others =
        [("minimum", "expanding"), ("shutdown", "manual_shutdown"), ("wakeup", "manual_shutdown")];
    for (name, owner) in others {
        if fields.has(name) && !uses.contains(&name) {
            let wrong = Wrong::new(Rule::Kind, format!("{name} means nothing in this type"));
            let at = fields.element.attribute(name).map_or(0..0, |one| one.at.clone());
            fields.error(at, name, wrong.expected(format!("it in type {owner} alone")));
        }
    }
    kind
}

fn starts(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<StartRange> {
    let mut starts = Vec::new();
    for element in fields.children(&schema::START) {
        let mut fields = fields.within(element, &schema::START);
        let range = StartRange {
            from: fields.time("from"),
            to: fields.time("to"),
            cutoff: fields.time("cutoff"),
        };
        if range.to < range.from && fields.good() {
            let wrong = Wrong::new(Rule::Window, "the latest start is before the earliest one");
            fields.error(element.span("to"), "to", wrong.expected("not before from"));
        }
        starts.push(range);
    }
    if starts.is_empty() {
        let wrong = Wrong::new(Rule::Missing, "the activity does not say when it can start");
        let at = fields.element.at.clone();
        fields.error(
            at,
            "",
            wrong.expected("one <start from=\"..\" to=\"..\" cutoff=\"..\"/> or more"),
        );
    }
    starts
}

fn after(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<Dependency> {
    let mut after = Vec::new();
    for element in fields.children(&schema::AFTER) {
        let mut fields = fields.within(element, &schema::AFTER);
        after.push(Dependency {
            prior: fields.need("activity", NOBODY, value::activity),
            statuses: fields.need("status", Vec::new(), words::statuses),
        });
    }
    after
}

fn uses(fields: &mut Fields<'_, '_, '_, '_>) -> (Categories, Vec<String>) {
    let (mut resources, mut zones) = (Categories::NONE, Vec::new());
    for element in fields.children(&schema::USES) {
        let mut fields = fields.within(element, &schema::USES);
        match fields.one_of(schema::USES.attributes) {
            Some("zone") => {
                let names = fields.names;
                let Some(zone) = fields.read("zone", |text| names.zone(text)) else { continue };
                match zones.contains(&zone) {
                    true => twice(&mut fields, "zone"),
                    false => zones.push(zone),
                }
            }
            Some(how) => {
                let bit = used_bit(&mut fields, how);
                match resources.overlaps(bit) {
                    true => twice(&mut fields, how),
                    false => resources = resources.union(bit),
                }
            }
            None => {}
        }
    }
    (resources, zones)
}

fn twice(fields: &mut Fields<'_, '_, '_, '_>, name: &str) {
    let wrong = Wrong::new(Rule::Duplicate, format!("the activity uses this {name} already"));
    let at = fields.element.span(name);
    fields.error(at, name, wrong.expected("each once"));
}

fn conditions(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<Condition> {
    let mut conditions = Vec::new();
    for element in fields.children(&schema::CONDITION) {
        let mut fields = fields.within(element, &schema::CONDITION);
        let (min, max) = limits(&mut fields);
        conditions.push(Condition {
            kind: fields.need("kind", Variable::Acm, |text| words::read(text, &VARIABLES)),
            name: fields.need("variable", String::new(), value::name),
            min,
            max,
        });
    }
    conditions
}

fn impacts(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<Impact> {
    let mut impacts = Vec::new();
    for element in fields.children(&schema::IMPACT) {
        let mut fields = fields.within(element, &schema::IMPACT);
        let names = fields.names;
        let timeline = fields.need("timeline", String::new(), |text| names.timeline(text));
        let effects = schema::IMPACT.attributes.get(1..).unwrap_or_default();
        if let Some(how) = fields.one_of(effects)
            && let Some(amount) = fields.read(how, value::number)
        {
            impacts.push(Impact { timeline, effect: effect(how, amount) });
        }
    }
    impacts
}

fn effect(how: &str, amount: i64) -> Effect {
    match how {
        "set_at_start" => Effect::SetAtStart(amount),
        "set_at_end" => Effect::SetAtEnd(amount),
        "hold" => Effect::Hold(amount),
        "add_at_start" => Effect::AddAtStart(amount),
        "add_at_end" => Effect::AddAtEnd(amount),
        _ => Effect::Rate(amount),
    }
}

fn constraints(fields: &mut Fields<'_, '_, '_, '_>) -> Vec<Constraint> {
    let mut constraints = Vec::new();
    for element in fields.children(&schema::CONSTRAINT) {
        let mut fields = fields.within(element, &schema::CONSTRAINT);
        let names = fields.names;
        let (min, max) = limits(&mut fields);
        let timeline = fields.need("timeline", String::new(), |text| names.timeline(text));
        constraints.push(Constraint { timeline, min, max });
    }
    constraints
}
