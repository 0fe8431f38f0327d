//! The mission of the native format, written.

use toml_edit::{Item, Table, Value};

use crate::format::write::native::{self, Names, Out};
use crate::format::write::text;
use crate::mission::{AgentSpec, DeviceSpec, Mission, ModeSpec};

/// The mission's table.
pub(crate) fn table(mission: &Mission) -> Table {
    let usual = Mission::default();
    let mut out = Out::default();
    if let Some(name) = &mission.name {
        out.put("name", name.as_str());
    }
    for (key, bytes) in [
        ("memory", mission.memory),
        ("memory_low", mission.memory_low),
        ("storage", mission.storage),
    ] {
        if let Some(bytes) = bytes {
            out.put(key, native::size(bytes));
        }
    }
    let waiting = u64::try_from(mission.waiting_requests).unwrap_or(u64::MAX);
    if mission.waiting_requests != usual.waiting_requests {
        out.put("waiting_requests", native::size(waiting));
    }
    out.unless("lease", usual.lease, mission.lease, native::duration);
    if let Some(battery) = mission.battery {
        let mut inner = Out::default();
        inner.put("low", i64::from(battery.low));
        out.table.insert("battery", Item::Table(inner.table));
    }
    put_categories(&mission.categories, &mut out);
    if mission.agents != usual.agents {
        put_all("agent", &mission.agents, agent, &mut out);
    }
    put_all("device", &mission.devices, |one| device(one, &mission.categories), &mut out);
    put_all("mode", &mission.modes, |one| mode(one, &mission.categories), &mut out);
    out.table
}

fn put_categories(names: &Names, out: &mut Out) {
    if !names.is_empty() {
        let inner = names.iter().map(|(name, bit)| (name, value(i64::from(*bit))));
        out.table.insert("categories", Item::Table(inner.collect()));
    }
}

fn put_all<T>(key: &str, all: &[T], write: impl Fn(&T) -> Table, out: &mut Out) {
    if !all.is_empty() {
        out.table.insert(key, Item::ArrayOfTables(all.iter().map(write).collect()));
    }
}

fn agent(agent: &AgentSpec) -> Table {
    let mut out = Out::default();
    out.put("name", agent.name.as_str());
    if let Some(supply) = agent.supply {
        out.put("supply_w", native::number(&text::watts(supply)));
    }
    out.table
}

fn device(device: &DeviceSpec, names: &Names) -> Table {
    let mut out = Out::default();
    out.put("name", device.name.as_str());
    out.put("kind", device.kind.as_str());
    out.put("agent", device.agent.as_str());
    if let Some(draw) = device.draw {
        out.put("draw_w", native::number(&text::watts(draw)));
    }
    if !device.categories.is_empty() {
        out.put("con", native::categories(device.categories, Some(names)));
    }
    if !device.parameters.is_empty() {
        let inner = device.parameters.iter().map(|(name, text)| (name, value(text.as_str())));
        out.table.insert("parameters", Item::Table(inner.collect()));
    }
    out.table
}

fn mode(mode: &ModeSpec, names: &Names) -> Table {
    let mut out = Out::default();
    out.put("name", mode.name.as_str());
    out.unless("floor", 0, mode.floor.level(), |level| i64::from(level).into());
    if !mode.blocks.is_empty() {
        out.put("blocks", native::categories(mode.blocks, Some(names)));
    }
    if !mode.reserves.is_empty() {
        out.put("reserves", native::strings(&mode.reserves));
    }
    out.table
}

fn value(value: impl Into<Value>) -> Item {
    Item::Value(value.into())
}
