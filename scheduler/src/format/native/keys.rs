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
