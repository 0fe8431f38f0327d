//! What an occurrence needs of the agents.

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;
use serde::{Deserialize, Serialize};

use crate::task::TaskPriority;
use crate::time::Duration;

/// What the tickets of an occurrence are for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Needs {
    /// At which priority; a task that cannot be pre-empted asks at
    /// [`TaskPriority::TOP`].
    pub priority: TaskPriority,
    /// Its categories.
    pub categories: Categories,
    /// Its own largest draw.
    pub draw: Milliwatts,
    /// The gates that it commands, by name.
    pub gates: Vec<String>,
    /// How long its body may take to stop, as declared.
    pub grace: Duration,
}
