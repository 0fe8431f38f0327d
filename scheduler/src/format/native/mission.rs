//! The mission of a native file.

use core::ops::Range;
use std::collections::BTreeMap;

use faregate_agents::Categories;
use toml::de::{DeTable, DeValue};

use crate::format::check;
use crate::format::diagnostic::Rule;
use crate::format::native::table::Table;
use crate::format::native::task::{self, Names};
use crate::format::native::{keys, value};
use crate::format::scalar;
use crate::format::wrong::{Report, Wrong, shown};
use crate::mission::{AgentSpec, BatterySpec, DeviceSpec, Mission, ModeSpec};

/// Reads the mission. What is wrong with it was told of when this returns.
pub(crate) fn read(table: &DeTable<'_>, at: Range<usize>, report: &mut Report<'_>) -> Mission {
    let mut table = Table::new(table, at, "mission.", report);
    let mut mission = Mission { name: table.read("name", value::name), ..Mission::default() };
    let complete = names(&mut table, &mut mission);
    let categories = mission.categories.clone();
    let names = Names { of_categories: Some(&categories), complete };
    agents(&mut table, &mut mission);
    devices(&mut table, &mut mission, names);
    modes(&mut table, &mut mission, names);
    installed(&mut table, &mut mission);
    table.finish(keys::MISSION);
    mission
}

/// Reads the names of categories; whether each could be read.
fn names(table: &mut Table<'_, '_, '_>, mission: &mut Mission) -> bool {
    let before = table.report.found.len();
    if let Some((inner, at)) = table.table("categories") {
        let inner = Table::new(inner, at, "mission.categories.", table.report);
        for (name, _, (value, at)) in inner.entries() {
            let read = value::number("the number of a category, 0 to 127", scalar::category);
            if let Some(bit) = inner.report.take(at, &inner.field(name), read(value)) {
                mission.categories.insert(name.to_owned(), bit);
            }
        }
    }
    table.report.found.len() == before
}

fn agents(table: &mut Table<'_, '_, '_>, mission: &mut Mission) {
    if table.value("agent").is_none() {
        return;
    }
    mission.agents.clear();
    if matches!(table.value("agent"), Some((DeValue::Array(all), _)) if all.is_empty()) {
        let wrong = Wrong::new(Rule::Missing, "there is no agent").expected("at least one");
        table.error(table.span("agent"), "agent", wrong);
    }
    let mut names = Unique::default();
    for (inner, at) in table.tables("agent") {
        let mut inner = Table::new(inner, at, "mission.agent.", table.report);
        let name = inner.need("name", value::name);
        names.check(name.as_ref(), "agent", &mut inner);
        let supply = inner.read("supply_w", value::watts);
        inner.finish(keys::AGENT);
        mission.agents.push(AgentSpec { name: name.unwrap_or_default(), supply });
    }
}

fn devices(table: &mut Table<'_, '_, '_>, mission: &mut Mission, names: Names<'_>) {
    let mut unique = Unique::default();
    for (inner, at) in table.tables("device") {
        let mut inner = Table::new(inner, at, "mission.device.", table.report);
        let name = inner.need("name", value::name);
        unique.check(name.as_ref(), "device", &mut inner);
        let device = DeviceSpec {
            name: name.unwrap_or_default(),
            kind: inner.need("kind", value::name).unwrap_or_default(),
            agent: agent(&mut inner, &mission.agents),
            draw: inner.read("draw_w", value::watts),
            categories: task::categories(&mut inner, "con", names).unwrap_or(Categories::NONE),
            parameters: parameters(&mut inner),
        };
        supplied(&device, &mission.agents, &mut inner);
        inner.finish(keys::DEVICE);
        mission.devices.push(device);
    }
}

/// The agent of a device: the only one there is need not be named.
fn agent(table: &mut Table<'_, '_, '_>, agents: &[AgentSpec]) -> String {
    if let (None, [only]) = (table.value("agent"), agents) {
        return only.name.clone();
    }
    let known = agents.iter().map(|agent| agent.name.as_str());
    // A name that could not be read may be the one that is meant.
    let complete = known.clone().all(|name| !name.is_empty());
    let read = |value: &DeValue<'_>| {
        let name = value::name(value)?;
        if complete && known.clone().all(|known| known != name) {
            return Err(check::no_such("agent", &name, known.clone()));
        }
        Ok(name)
    };
    table.need("agent", read).unwrap_or_default()
}

fn supplied(device: &DeviceSpec, agents: &[AgentSpec], table: &mut Table<'_, '_, '_>) {
    let agent = agents.iter().find(|agent| agent.name == device.agent);
    let supply = agent.and_then(|agent| agent.supply);
    if let Some((supply, draw)) = supply.zip(device.draw).filter(|(supply, draw)| draw > supply) {
        let message = format!("draws up to {draw}, and {} supplies {supply}", device.agent);
        let wrong = Wrong::new(Rule::NeverRuns, message).help("as it is, nobody can turn it on");
        let field = table.field("draw_w");
        table.report.warn(table.span("draw_w"), &field, wrong);
    }
}

/// What else the kind of device wants to know: single values, kept as text.
fn parameters(table: &mut Table<'_, '_, '_>) -> BTreeMap<String, String> {
    let Some((inner, at)) = table.table("parameters") else { return BTreeMap::new() };
    let inner = Table::new(inner, at, "mission.device.parameters.", table.report);
    let mut all = BTreeMap::new();
    for (name, _, (value, at)) in inner.entries() {
        if let Some(text) = inner.report.take(at, &inner.field(name), parameter(value)) {
            all.insert(name.to_owned(), text);
        }
    }
    all
}

fn parameter(value: &DeValue<'_>) -> Result<String, Wrong> {
    match value {
        DeValue::String(text) => Ok(text.clone().into_owned()),
        DeValue::Boolean(value) => Ok(value.to_string()),
        DeValue::Datetime(time) => Ok(time.to_string()),
        _ => value::digits(value, "a string, a number, a truth value or a time"),
    }
}

fn modes(table: &mut Table<'_, '_, '_>, mission: &mut Mission, names: Names<'_>) {
    let mut unique = Unique::default();
    for (inner, at) in table.tables("mode") {
        let mut inner = Table::new(inner, at, "mission.mode.", table.report);
        let name = inner.need("name", value::name);
        unique.check(name.as_ref(), "mode", &mut inner);
        let floor = value::number("a priority, 0 to 239", scalar::priority);
        let mode = ModeSpec {
            name: name.unwrap_or_default(),
            floor: inner.read("floor", floor).unwrap_or_default(),
            blocks: task::categories(&mut inner, "blocks", names).unwrap_or(Categories::NONE),
            reserves: reserves(&mut inner, &mission.devices),
        };
        inner.finish(keys::MODE);
        mission.modes.push(mode);
    }
}

fn reserves(table: &mut Table<'_, '_, '_>, devices: &[DeviceSpec]) -> Vec<String> {
    let known = devices.iter().map(|device| device.name.as_str());
    let complete = known.clone().all(|name| !name.is_empty());
    let read = |value: &DeValue<'_>| {
        let name = value::name(value)?;
        if complete && known.clone().all(|known| known != name) {
            return Err(check::no_such("device", &name, known.clone()));
        }
        Ok(name)
    };
    table.list("reserves", read).unwrap_or_default()
}

fn installed(table: &mut Table<'_, '_, '_>, mission: &mut Mission) {
    mission.memory = table.read("memory", value::size);
    mission.memory_low = table.read("memory_low", value::size);
    mission.storage = table.read("storage", value::size);
    if let Some(lease) = table.read("lease", value::duration) {
        mission.lease = lease;
    }
    let waiting = value::number("how many requests may wait", scalar::bytes);
    let waiting = table.read("waiting_requests", waiting);
    if let Some(waiting) = waiting.and_then(|waiting| usize::try_from(waiting).ok()) {
        mission.waiting_requests = waiting;
    }
    if let Some((inner, at)) = table.table("battery") {
        let mut inner = Table::new(inner, at, "mission.battery.", table.report);
        let low = inner.need("low", value::number("a percentage, 0 to 100", scalar::percent));
        inner.finish(keys::BATTERY);
        mission.battery = Some(BatterySpec { low: low.unwrap_or_default() });
    }
}

/// Names that may be given once.
#[derive(Default)]
struct Unique {
    first: BTreeMap<String, Range<usize>>,
}

impl Unique {
    fn check(&mut self, name: Option<&String>, what: &str, table: &mut Table<'_, '_, '_>) {
        let Some(name) = name else { return };
        let at = table.span("name");
        if let Some(first) = self.first.insert(name.clone(), at.clone()) {
            let message = format!("there is another {what} {}", shown(name));
            let wrong = Wrong::new(Rule::Duplicate, message).expected("a name of its own");
            let field = table.field("name");
            table.report.error_with(at, &field, wrong, (first, "here first".to_owned()));
        }
    }
}
