//! Faults from a file.

use std::path::Path;

use faregate_planner::{ActivityId, Parameters, Plan, State};
use faregate_rehearsal::{Mishap, Script};

use crate::disk;
use crate::exit::Failure;

/// Reads what goes wrong, and makes sure that it is about what there is.
pub(super) fn read(
    path: &Path,
    plan: &Plan,
    parameters: &Parameters,
    state: &State,
) -> Result<Script, Failure> {
    let name = path.display();
    let text = disk::read(path).map_err(Failure::failed)?;
    let mishaps: Vec<Mishap> = serde_json::from_slice(&text).map_err(|error| {
        Failure::failed(format!(
            "{name} is no list of faults, as `plan run --help` has one: {error}"
        ))
    })?;
    for mishap in &mishaps {
        unknown(mishap, plan, parameters, state)
            .map_or(Ok(()), |what| Err(Failure::failed(format!("{name}: there is no {what}"))))?;
    }
    Ok(Script(mishaps))
}

fn unknown(mishap: &Mishap, plan: &Plan, parameters: &Parameters, state: &State) -> Option<String> {
    let has = |id: &ActivityId| plan.activities.iter().any(|activity| activity.id == *id);
    match mishap {
        Mishap::HeaterDead { zone, .. } => {
            let known = parameters.zones.iter().any(|one| one.name == *zone);
            (!known).then(|| format!("zone `{zone}`"))
        }
        Mishap::Window { index, .. } => {
            (*index >= state.windows.len()).then(|| format!("window {index}: the first one is 0"))
        }
        Mishap::Veto { id, .. } | Mishap::Stop { id, .. } => (!has(id)).then(|| id.to_string()),
        _ => None,
    }
}
