//! What a task needs, against what the mission has.

use core::ops::Range;

use faregate_tickets::amount::Milliwatts;

use crate::format::check::Judge;
use crate::format::diagnostic::Rule;
use crate::format::draft::Draft;
use crate::format::wrong::{Report, Wrong};
use crate::mission::Mission;

/// A task that needs more than there is never runs, and blocks nobody: it is
/// loaded, and told of.
pub(crate) fn task(draft: &Draft, judge: Judge<'_>, report: &mut Report<'_>) {
    let Some(mission) = judge.mission else { return };
    if draft.good(["power"])
        && draft.task.battery > 0
        && mission.battery.is_none()
        && judge.mission_good
    {
        report.error(draft.span("power"), "power", no_battery());
    }
    let sizes = [
        ("memory", draft.task.memory, mission.memory),
        ("storage", draft.task.storage, mission.storage),
    ];
    for (field, needed, installed) in sizes {
        if let Some(installed) = installed.filter(|installed| needed > *installed) {
            let message = format!("needs {needed} bytes of {field}, and there are {installed}");
            never(draft.span(field), field, message, report);
        }
    }
    draws(draft, mission, report);
}

fn no_battery() -> Wrong {
    Wrong::new(Rule::NoBattery, "a state of charge is asked for, and the mission has no battery")
        .expected("0")
        .help("give the mission a battery: [mission.battery]")
}

fn draws(draft: &Draft, mission: &Mission, report: &mut Report<'_>) {
    for (index, agent) in mission.agents.iter().enumerate() {
        let Some(supply) = agent.supply else { continue };
        let own = if index == 0 { draft.task.peak_draw } else { Milliwatts::ZERO };
        let needed = of_gates(draft, mission, &agent.name).fold(own, Milliwatts::saturating_add);
        if needed > supply {
            let field = if own > supply || !draft.has("gates") { "draw_w" } else { "gates" };
            let message = format!("draws up to {needed}, and {} supplies {supply}", agent.name);
            never(draft.span(field), field, message, report);
        }
    }
}

/// The draws of the devices at this agent that the task commands.
fn of_gates(draft: &Draft, mission: &Mission, agent: &str) -> impl Iterator<Item = Milliwatts> {
    (mission.devices.iter())
        .filter(move |device| device.agent == agent && draft.task.gates.contains(&device.name))
        .filter_map(|device| device.draw)
}

fn never(at: Range<usize>, field: &str, message: String, report: &mut Report<'_>) {
    let wrong = Wrong::new(Rule::NeverRuns, message).help("as it is, this task never runs");
    report.warn(at, field, wrong);
}
