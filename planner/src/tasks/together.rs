//! Whether a plan's activities can be executed on a mission, each by itself and
//! beside the others.

use std::collections::{BTreeMap, BTreeSet};

use faregate_scheduler::Mission;
use faregate_tickets::amount::Milliwatts;

use super::library::{self, Library};
use super::{Disagreement, Misfit, activity};
use crate::Plan;
use crate::plan::{Activity, ActivityId};

/// Everything that keeps a plan's activities from their tickets on a mission, or
/// lets the planner put two beside each other that the agents keep apart.
///
/// The planner knows resource bits and no gates: two activities that command one
/// gate must share a bit, unless they can never overlap. They cannot if one
/// depends on the other, if both are of one group, or if all start ranges of one
/// are over before those of the other begin.
#[must_use]
pub fn plan_fits(plan: &Plan, library: &Library, mission: &Mission) -> Vec<Disagreement> {
    let gates: Vec<_> = plan.activities.iter().map(|one| gates(one, library)).collect();
    let mut found = Vec::new();
    for (activity, gates) in plan.activities.iter().zip(&gates) {
        alone(activity, gates.as_deref(), mission, &mut found);
    }
    let priors = priors(plan);
    for (gate, users) in users(plan, &gates) {
        beside(gate, &users, &priors, &mut found);
    }
    found
}

/// What its sequence commands; none: nobody knows its sequence.
fn gates(activity: &Activity, library: &Library) -> Option<Vec<String>> {
    let Some(name) = &activity.sequence else { return Some(Vec::new()) };
    library.steps(name).map(library::gates)
}

fn alone(
    one: &Activity,
    gates: Option<&[String]>,
    mission: &Mission,
    found: &mut Vec<Disagreement>,
) {
    let Some(gates) = gates else {
        let name = one.sequence.clone().unwrap_or_default();
        return found.push(Disagreement::Activity(Misfit::Sequence(one.id, name)));
    };
    let misfits = activity::misfits(mission, one, gates);
    found.extend(misfits.into_iter().map(Disagreement::Activity));
    for agent in &mission.agents {
        let of_agent = |device: &&faregate_scheduler::mission::DeviceSpec| {
            device.agent == agent.name && gates.contains(&device.name)
        };
        let draws = mission.devices.iter().filter(of_agent).filter_map(|device| device.draw);
        let devices = draws.fold(Milliwatts::ZERO, Milliwatts::saturating_add);
        if let Some(supply) = agent.supply.filter(|supply| *supply < devices) {
            let (name, agent) = (words(one), agent.name.clone());
            found.push(Disagreement::Supply { name, agent, devices, supply });
        }
    }
}

/// The activities that command each gate.
fn users<'a>(
    plan: &'a Plan,
    gates: &'a [Option<Vec<String>>],
) -> BTreeMap<&'a str, Vec<&'a Activity>> {
    let mut users: BTreeMap<&str, Vec<&Activity>> = BTreeMap::new();
    for (activity, gates) in plan.activities.iter().zip(gates) {
        for gate in gates.iter().flatten() {
            users.entry(gate).or_default().push(activity);
        }
    }
    users
}

fn beside(gate: &str, users: &[&Activity], priors: &Priors, found: &mut Vec<Disagreement>) {
    for (place, one) in users.iter().enumerate() {
        for other in &users[place + 1..] {
            let apart = one.resources.overlaps(other.resources)
                || depends(priors, one.id, other.id)
                || depends(priors, other.id, one.id)
                || (one.group.is_some() && one.group == other.group)
                || never_meet(one, other);
            if !apart {
                let (gate, names) = (gate.to_owned(), [words(one), words(other)]);
                found.push(Disagreement::Gate { gate, names });
            }
        }
    }
}

/// Whom each activity comes after, over others, too.
type Priors = BTreeMap<ActivityId, BTreeSet<ActivityId>>;

fn priors(plan: &Plan) -> Priors {
    let direct: BTreeMap<_, Vec<_>> = plan
        .activities
        .iter()
        .map(|one| (one.id, one.after.iter().map(|on| on.prior).collect()))
        .collect();
    let all = |id: &ActivityId| {
        let (mut all, mut open) = (BTreeSet::new(), vec![*id]);
        while let Some(next) = open.pop() {
            let new = direct.get(&next).into_iter().flatten().filter(|prior| all.insert(**prior));
            open.extend(new);
        }
        all
    };
    direct.keys().map(|id| (*id, all(id))).collect()
}

fn depends(priors: &Priors, one: ActivityId, on: ActivityId) -> bool {
    priors.get(&one).is_some_and(|priors| priors.contains(&on))
}

fn never_meet(one: &Activity, other: &Activity) -> bool {
    let apart = |a: &crate::plan::StartRange, b: &crate::plan::StartRange| {
        a.cutoff <= b.from || b.cutoff <= a.from
    };
    one.starts.iter().all(|a| other.starts.iter().all(|b| apart(a, b)))
}

fn words(activity: &Activity) -> String {
    let number = activity.id.get();
    activity.name.as_ref().map_or_else(|| number.to_string(), |name| format!("{number} {name}"))
}
