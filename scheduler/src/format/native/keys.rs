//! The keys of the native format. The reader knows these, and the reference
//! (docs/schedule-format.md) lists them; a test compares the two.

/// At the top.
pub(crate) const FILE: &[&str] = &["mission", "task"];

/// What a task does: one of these.
pub(crate) const BODY: &[&str] =
    &["run", "function", "step", "hold", "clear", "remove", "load", "enter_mode", "leave_mode"];

/// Of a task.
pub(crate) const TASK: &[&str] = &[
    "id",
    "name",
    "run",
    "function",
    "args",
    "step",
    "hold",
    "clear",
    "remove",
    "load",
    "enter_mode",
    "leave_mode",
    "st",
    "et",
    "window",
    "cutoff",
    "interval",
    "dur",
    "dur_min",
    "dur_max",
    "con",
    "gap",
    "pri",
    "memory",
    "storage",
    "power",
    "draw_w",
    "average_draw_w",
    "data",
    "gates",
    "preempt",
    "grace",
    "signal",
    "restart",
    "restart_limit",
    "back_off",
    "overrun",
    "heartbeat",
    "after",
    "cleanup",
    "mandatory",
];

/// Of a window of a task.
pub(crate) const WINDOW: &[&str] = &["st", "et"];

/// Of a step of a sequence.
pub(crate) const STEP: &[&str] = &["at", "gate", "command", "args", "continue"];

/// Of a dependency of a task.
pub(crate) const AFTER: &[&str] = &["task", "status"];

/// Of the mission.
pub(crate) const MISSION: &[&str] = &[
    "name",
    "agent",
    "device",
    "categories",
    "mode",
    "battery",
    "memory",
    "memory_low",
    "storage",
    "waiting_requests",
    "lease",
];

/// Of a ticket agent.
pub(crate) const AGENT: &[&str] = &["name", "supply_w"];

/// Of a device.
pub(crate) const DEVICE: &[&str] = &["name", "kind", "agent", "draw_w", "con", "parameters"];

/// Of a mode.
pub(crate) const MODE: &[&str] = &["name", "floor", "blocks", "reserves"];

/// Of the battery.
pub(crate) const BATTERY: &[&str] = &["low"];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::{self, Kind, Rule};

    const REFERENCE: &str = include_str!("../../../../docs/schedule-format.md");

    /// The first cells of the tables under this heading.
    fn listed(heading: &str) -> Vec<&'static str> {
        let (_, section) = REFERENCE.split_once(&format!("\n{heading}\n")).unwrap();
        let end = section.find("\n#").unwrap_or(section.len());
        let rows = section[..end].lines().filter_map(|line| line.strip_prefix("| `"));
        rows.filter_map(|row| row.split('`').next()).collect()
    }

    #[test]
    fn the_reference_lists_every_key_and_no_other() {
        let all = [
            ("### The file", FILE),
            ("### A task", TASK),
            ("### A window", WINDOW),
            ("### A step", STEP),
            ("### A dependency", AFTER),
            ("### The mission", MISSION),
            ("### An agent", AGENT),
            ("### A device", DEVICE),
            ("### A mode", MODE),
            ("### The battery", BATTERY),
        ];
        for (heading, keys) in all {
            assert_eq!(listed(heading), keys, "{heading}");
        }
    }

    #[test]
    fn the_reference_lists_every_column_and_rule() {
        let columns = listed("## SMAARTE's formats");
        let mut known = format::columns::Column::ALL.map(format::columns::Column::name);
        let mut columns = columns;
        columns.sort_unstable();
        known.sort_unstable();
        assert_eq!(columns, known);
        let mut rules = listed("## What is wrong with a file");
        let known = Rule::ALL.into_iter().filter(|rule| !Rule::PLANNER.contains(rule));
        let mut known: Vec<_> = known.map(Rule::name).collect();
        rules.sort_unstable();
        known.sort_unstable();
        assert_eq!(rules, known);
    }

    #[test]
    fn the_examples_of_the_reference_can_be_loaded() {
        let blocks = REFERENCE.split("```").skip(1).step_by(2);
        let mut read = Vec::new();
        for block in blocks {
            let (name, text) = block.split_once('\n').unwrap();
            let kind = Kind::of(&format!("a.{name}")).unwrap();
            let loaded = format::read(&format!("a.{name}"), text.as_bytes()).unwrap();
            read.push((kind, loaded.tasks.len(), loaded.warnings.len()));
        }
        assert_eq!(read, [(Kind::Csv, 3, 0), (Kind::Txt, 2, 0), (Kind::Toml, 2, 0)]);
    }
}
