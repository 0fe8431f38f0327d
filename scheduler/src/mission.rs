//! The mission that a schedule runs on: agents and their margins, devices, the
//! names of categories and modes, and what is installed.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;
use serde::{Deserialize, Serialize};

use crate::task::TaskPriority;
use crate::time::Duration;

/// What a schedule can count on.
///
/// The default has nothing but categories: what a SMAARTE file needs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mission {
    /// What people call it.
    pub name: Option<String>,
    /// Ticket agents, with the supply of each, where it has one. The first is
    /// the one that tasks' own draws are charged to.
    pub agents: Vec<AgentSpec>,
    /// Devices behind gates.
    pub devices: Vec<DeviceSpec>,
    /// Names of conflict categories (bit numbers 0 to 127).
    pub categories: BTreeMap<String, u8>,
    /// Modes that can be entered.
    pub modes: Vec<ModeSpec>,
    /// Bytes of memory for tasks; none: not checked.
    pub memory: Option<u64>,
    /// Bytes of storage for tasks; none: not checked.
    pub storage: Option<u64>,
    /// Whether there is a battery whose state of charge is estimated.
    pub battery: Option<BatterySpec>,
    /// Running tasks are pre-empted while less memory than this is available.
    pub memory_low: Option<u64>,
    /// How many requests may wait at the agents at a time.
    pub waiting_requests: usize,
    /// The lease of tickets that tasks hold: how long a device stays on after
    /// the manager has died.
    pub lease: Duration,
}

/// A ticket agent of the mission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AgentSpec {
    /// Its name.
    pub name: String,
    /// Its supply; none: no margin is kept.
    pub supply: Option<Milliwatts>,
}

/// A device of the mission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceSpec {
    /// The gate's name, by which tasks command it.
    pub name: String,
    /// What kind of device it is: the program that runs the mission knows.
    pub kind: String,
    /// Its agent's name.
    pub agent: String,
    /// Its largest draw, where it is not the kind's own.
    pub draw: Option<Milliwatts>,
    /// Its conflict categories.
    pub categories: Categories,
    /// What else the kind wants to know.
    pub parameters: BTreeMap<String, String>,
}

/// A mode that can be entered and left.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModeSpec {
    /// Its name.
    pub name: String,
    /// While it lasts, no task below this priority runs.
    pub floor: TaskPriority,
    /// While it lasts, no task that uses one of these categories runs.
    pub blocks: Categories,
    /// While it lasts, these gates are taken, and their devices are off.
    pub reserves: Vec<String>,
}

/// The battery of the mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BatterySpec {
    /// Running tasks are pre-empted below this state of charge, in percent.
    pub low: u8,
}

impl Default for Mission {
    fn default() -> Self {
        Self {
            name: None,
            agents: vec![AgentSpec { name: "tasks".into(), supply: None }],
            devices: Vec::new(),
            categories: BTreeMap::new(),
            modes: Vec::new(),
            memory: None,
            storage: None,
            battery: None,
            memory_low: None,
            waiting_requests: 16,
            lease: Duration::from_secs(2),
        }
    }
}
