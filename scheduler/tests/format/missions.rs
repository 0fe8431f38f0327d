//! Random missions, each of which a native file can say.

use std::collections::BTreeSet;

use faregate_scheduler::Mission;
use faregate_scheduler::mission::{AgentSpec, BatterySpec, DeviceSpec, ModeSpec};
use faregate_scheduler::task::TaskPriority;
use faregate_tickets::amount::Milliwatts;
use proptest::collection::{btree_map, vec};
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;

use crate::arbitrary::{categories, duration, name, word};

fn names(most: usize) -> impl Strategy<Value = Vec<String>> {
    proptest::collection::btree_set(name(), 1..=most).prop_map(|names| names.into_iter().collect())
}

fn device(agents: Vec<String>) -> impl Strategy<Value = DeviceSpec> {
    let parameters = btree_map(name(), word(), 0..3);
    let draw = option::of(any::<u64>().prop_map(Milliwatts::new));
    (name(), name(), select(agents), draw, categories(), parameters).prop_map(
        |(name, kind, agent, draw, categories, parameters)| DeviceSpec {
            name,
            kind,
            agent,
            draw,
            categories,
            parameters,
        },
    )
}

fn mode(devices: Vec<DeviceSpec>) -> impl Strategy<Value = ModeSpec> {
    let some = devices.iter().take(2).map(|device| device.name.clone()).collect::<Vec<_>>();
    (name(), 0..=239_u8, categories(), any::<bool>()).prop_map(
        move |(name, floor, blocks, reserves)| ModeSpec {
            name,
            floor: TaskPriority::new(floor).unwrap_or_default(),
            blocks,
            reserves: if reserves { some.clone() } else { Vec::new() },
        },
    )
}

/// Any mission that makes sense.
pub(crate) fn mission() -> impl Strategy<Value = Mission> {
    let bytes = || option::of(0..1_u64 << 50);
    let installed = (bytes(), bytes(), bytes(), option::of(0..=100_u8), 0..1_000_usize, duration());
    let names = (option::of(name()), btree_map(name(), 0..128_u8, 0..5), names(3));
    let supplies = vec(option::of(any::<u64>().prop_map(Milliwatts::new)), 3);
    (installed, names, supplies)
        .prop_map(
            |(
                (memory, storage, low, battery, waiting, lease),
                (name, categories, agents),
                supplies,
            )| {
                let agents = agents.into_iter().zip(supplies);
                Mission {
                    name,
                    categories,
                    memory,
                    storage,
                    memory_low: low,
                    battery: battery.map(|low| BatterySpec { low }),
                    waiting_requests: waiting,
                    lease,
                    agents: agents.map(|(name, supply)| AgentSpec { name, supply }).collect(),
                    ..Mission::default()
                }
            },
        )
        .prop_flat_map(|mission| {
            let agents = mission.agents.iter().map(|agent| agent.name.clone()).collect();
            vec(device(agents), 0..4).prop_map(move |mut devices| {
                let mut seen = BTreeSet::new();
                devices.retain(|device| seen.insert(device.name.clone()));
                Mission { devices, ..mission.clone() }
            })
        })
        .prop_flat_map(|mission| {
            vec(mode(mission.devices.clone()), 0..3).prop_map(move |mut modes| {
                let mut seen = BTreeSet::new();
                modes.retain(|mode| seen.insert(mode.name.clone()));
                Mission { modes, ..mission.clone() }
            })
        })
}
