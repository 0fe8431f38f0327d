//! Whether the parameters of a plan and a mission agree.

use core::fmt;

use faregate_scheduler::Mission;
use faregate_tickets::amount::Milliwatts;

use super::{Misfit, engines};
use crate::Parameters;

/// Something that the parameters and the mission say differently.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Disagreement {
    /// The planner would allow more power at a time than there is.
    Peak {
        /// What the parameters allow.
        limit: Milliwatts,
        /// What the first agent of the mission has.
        supply: Milliwatts,
    },
    /// The mission has no agent that could give tickets for power.
    NoAgent,
    /// A resource of the parameters is not a category of the mission.
    NoCategory(String),
    /// A resource has another bit than the category of its name.
    Bit {
        /// Its name.
        name: String,
        /// Its bit by the parameters.
        parameters: u8,
        /// Its bit by the mission.
        mission: u8,
    },
    /// One bit has two names.
    Names {
        /// The bit.
        bit: u8,
        /// Its name by the parameters.
        parameters: String,
        /// Its name by the mission.
        mission: String,
    },
    /// There is no category for an engine.
    NoEngine(String),
    /// No device of the mission heats a zone.
    NoHeater(String),
    /// The heaters of a zone draw more than the parameters say.
    Heater {
        /// The zone.
        zone: String,
        /// What the parameters say.
        peak: Milliwatts,
        /// What its devices draw.
        devices: Milliwatts,
    },
    /// Two activities command one gate, can overlap, and share no resource bit:
    /// the planner would put them beside each other.
    Gate {
        /// The gate.
        gate: String,
        /// Their numbers and names.
        names: [String; 2],
    },
    /// The devices of an activity draw more than an agent has.
    Supply {
        /// The number and name of the activity.
        name: String,
        /// The agent.
        agent: String,
        /// What the devices draw there.
        devices: Milliwatts,
        /// What it has.
        supply: Milliwatts,
    },
    /// An activity cannot become a task.
    Activity(Misfit),
}

/// Everything that the parameters and the mission say differently: so that a
/// timed plan could be executed on this mission.
///
/// The peak is compared with the supply of the mission's first agent, resources
/// with its categories, engines with the categories `engine 1`, `engine 2`, ...,
/// and zones with the devices that have a parameter `zone`.
#[must_use]
pub fn mission_fits(parameters: &Parameters, mission: &Mission) -> Vec<Disagreement> {
    let mut found = Vec::new();
    peak(parameters, mission, &mut found);
    resources(parameters, mission, &mut found);
    named_engines(parameters, mission, &mut found);
    zones(parameters, mission, &mut found);
    found
}

fn peak(parameters: &Parameters, mission: &Mission, found: &mut Vec<Disagreement>) {
    let Some(agent) = mission.agents.first() else {
        return found.push(Disagreement::NoAgent);
    };
    if let Some(supply) = agent.supply.filter(|supply| *supply < parameters.peak_limit) {
        found.push(Disagreement::Peak { limit: parameters.peak_limit, supply });
    }
}

fn resources(parameters: &Parameters, mission: &Mission, found: &mut Vec<Disagreement>) {
    for (name, bit) in &parameters.resources {
        match mission.categories.get(name) {
            None => found.push(Disagreement::NoCategory(name.clone())),
            Some(other) if other != bit => {
                let (name, parameters, mission) = (name.clone(), *bit, *other);
                found.push(Disagreement::Bit { name, parameters, mission });
            }
            Some(_) => {}
        }
        let others = mission.categories.iter().filter(|(other, of)| *of == bit && *other != name);
        found.extend(others.map(|(other, _)| Disagreement::Names {
            bit: *bit,
            parameters: name.clone(),
            mission: other.clone(),
        }));
    }
}

fn named_engines(parameters: &Parameters, mission: &Mission, found: &mut Vec<Disagreement>) {
    let engines = 0..usize::try_from(parameters.engines).unwrap_or(usize::MAX);
    let missing = engines.take(129).filter(|one| engines::category(mission, *one).is_none());
    found.extend(missing.map(|engine| Disagreement::NoEngine(engines::name(engine))));
}

fn zones(parameters: &Parameters, mission: &Mission, found: &mut Vec<Disagreement>) {
    for zone in &parameters.zones {
        let heaters = heaters(mission, &zone.name);
        if heaters.is_empty() {
            found.push(Disagreement::NoHeater(zone.name.clone()));
        }
        let devices = mission.devices.iter().filter(|one| heaters.contains(&one.name));
        let devices = devices.filter_map(|one| one.draw);
        let devices = devices.fold(Milliwatts::ZERO, Milliwatts::saturating_add);
        let (zone, peak) = (zone.name.clone(), zone.load.peak);
        if devices > peak {
            found.push(Disagreement::Heater { zone, peak, devices });
        }
    }
}

/// The devices that heat a zone.
pub(super) fn heaters(mission: &Mission, zone: &str) -> Vec<String> {
    let heats = |value: Option<&String>| value.is_some_and(|value| value == zone);
    let devices = mission.devices.iter().filter(|one| heats(one.parameters.get("zone")));
    devices.map(|one| one.name.clone()).collect()
}

impl fmt::Display for Disagreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Peak { limit, supply } => write!(
                f,
                "the parameters allow a peak of {limit}, and the mission's first agent has {supply}"
            ),
            Self::NoAgent => f.write_str("the mission has no agent that could give power"),
            Self::NoCategory(name) => write!(f, "the mission has no category `{name}`"),
            Self::Bit { name, parameters, mission } => write!(
                f,
                "`{name}` is bit {parameters} of the parameters, and category {mission} of the \
                 mission"
            ),
            Self::Names { bit, parameters, mission } => write!(
                f,
                "bit {bit} is `{parameters}` by the parameters, and `{mission}` by the mission"
            ),
            Self::NoEngine(name) => {
                write!(f, "the mission has no category `{name}`: each sequence engine needs one")
            }
            Self::NoHeater(zone) => write!(
                f,
                "no device of the mission heats the zone `{zone}`: give its heater the parameter \
                 zone = \"{zone}\""
            ),
            Self::Gate { gate, names: [one, other] } => write!(
                f,
                "activities `{one}` and `{other}` command the gate `{gate}`, can overlap, and \
                 share no resource: give both the same one"
            ),
            Self::Supply { name, agent, devices, supply } => write!(
                f,
                "the devices of activity `{name}` draw {devices} at the agent `{agent}`, which \
                 has {supply}"
            ),
            Self::Activity(misfit) => misfit.fmt(f),
            Self::Heater { zone, peak, devices } => write!(
                f,
                "the heaters of zone `{zone}` draw {devices}, and the parameters say {peak}"
            ),
        }
    }
}
