//! Which elements there are, with their attributes and what can be in them.
//! The reader knows these, and `docs/plan-format.md` and `plan.xsd` list them:
//! tests compare the three.

/// An element: its attributes in the order in which they are written.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) name: &'static str,
    pub(crate) attributes: &'static [&'static str],
    pub(crate) children: &'static [&'static Self],
}

/// Without children.
const fn leaf(name: &'static str, attributes: &'static [&'static str]) -> Known {
    Known { name, attributes, children: &[] }
}

pub(crate) const PLAN: Known = Known {
    name: "plan",
    attributes: &[
        "version",
        "name",
        "handover",
        "handover_min_soc",
        "end",
        "max_delta_data",
        "next_plan",
    ],
    children: &[&ACTIVITY],
};

pub(crate) const ACTIVITY: Known = Known {
    name: "activity",
    attributes: &[
        "id", "name", "type", "sequence", "priority", "value", "duration", "minimum", "shutdown",
        "wakeup", "marginal", "energy", "peak", "data", "engines", "group", "pausable",
    ],
    children: &[&START, &AFTER, &USES, &CONDITION, &IMPACT, &CONSTRAINT],
};

pub(crate) const START: Known = leaf("start", &["from", "to", "cutoff"]);
pub(crate) const AFTER: Known = leaf("after", &["activity", "status"]);
pub(crate) const USES: Known = leaf("uses", &["resource", "bit", "zone"]);
pub(crate) const CONDITION: Known = leaf("condition", &["kind", "variable", "min", "max"]);
pub(crate) const IMPACT: Known = leaf(
    "impact",
    &["timeline", "set_at_start", "set_at_end", "hold", "add_at_start", "add_at_end", "rate"],
);
pub(crate) const CONSTRAINT: Known = leaf("constraint", &["timeline", "min", "max"]);

pub(crate) const PARAMETERS: Known = Known {
    name: "parameters",
    attributes: &[
        "version",
        "mandatory_from",
        "soft_min_soc",
        "hard_min_soc",
        "max_soc",
        "peak_limit",
        "engines",
        "rtg",
        "base",
        "min_awake",
        "min_sleep",
        "commit",
        "expansion_grace",
        "handover_tolerance",
        "soft_samples",
    ],
    children: &[&AWAKE, &WAKEUP, &SHUTDOWN, &DAY, &ZONE, &TIMELINE, &RESOURCE],
};

pub(crate) const AWAKE: Known = leaf("awake", &["marginal", "peak"]);
pub(crate) const WAKEUP: Known = leaf("wakeup", &["duration", "marginal", "peak"]);
pub(crate) const SHUTDOWN: Known = leaf("shutdown", &["duration", "marginal", "peak"]);
pub(crate) const DAY: Known = leaf("day", &["length", "midnight"]);
pub(crate) const ZONE: Known =
    Known { name: "zone", attributes: &["name", "marginal", "peak"], children: &[&PREHEAT] };
pub(crate) const PREHEAT: Known = leaf("preheat", &["from", "duration"]);
pub(crate) const TIMELINE: Known = leaf("timeline", &["name", "kind", "initial", "min", "max"]);
pub(crate) const RESOURCE: Known = leaf("resource", &["name", "bit"]);

pub(crate) const STATE: Known = Known {
    name: "state",
    attributes: &["version", "now", "mode", "mode_since", "charge", "capacity"],
    children: &[&HEATING, &COLD, &VARIABLE, &VALUE, &ENDED, &RUNNING, &WINDOW],
};

pub(crate) const HEATING: Known = leaf("heating", &["zone", "since"]);
pub(crate) const COLD: Known = leaf("cold", &["zone"]);
pub(crate) const VARIABLE: Known = leaf("variable", &["name", "value"]);
pub(crate) const VALUE: Known = leaf("timeline", &["name", "value"]);
pub(crate) const ENDED: Known = leaf("ended", &["activity", "outcome", "started", "ended", "data"]);
pub(crate) const RUNNING: Known =
    leaf("running", &["activity", "started", "ends", "cutoff", "paused", "data"]);
pub(crate) const WINDOW: Known = Known {
    name: "window",
    attributes: &["name", "start", "end", "awake", "marginal", "peak", "data", "engines"],
    children: &[&WINDOW_USES],
};
pub(crate) const WINDOW_USES: Known = leaf("uses", &["resource", "bit"]);
