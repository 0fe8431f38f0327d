//! What an activity does to named timelines, and what it asks of them.

use serde::{Deserialize, Serialize};

/// A change of a named timeline.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Impact {
    /// The timeline's name.
    pub timeline: String,
    /// What it does.
    pub effect: Effect,
}

/// What an activity does to a timeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Effect {
    /// State: sets the value at its start.
    SetAtStart(i64),
    /// State: sets the value at its end.
    SetAtEnd(i64),
    /// Unit and renewable: takes so much from its start to its end.
    Hold(i64),
    /// Consumable: adds so much at its start.
    AddAtStart(i64),
    /// Consumable: adds so much at its end.
    AddAtEnd(i64),
    /// Consumable: adds so much for each second while it runs.
    Rate(i64),
}

/// A range that a named timeline must keep while an activity runs.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Constraint {
    /// The timeline's name.
    pub timeline: String,
    /// The smallest value, inclusive.
    pub min: i64,
    /// The largest value, inclusive.
    pub max: i64,
}
