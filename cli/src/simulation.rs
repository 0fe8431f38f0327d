//! The simulated mission: devices behind real gates, on buses that trip.
//!
//! | module | what |
//! |---|---|
//! | `devices` | which devices of a mission can be simulated |
//! | `driver` | a unit behind a gate, commanded by name |
//! | `craft` | one payload for each agent, and its sensors |
//! | `loads` | what the tasks themselves draw |

mod craft;
mod devices;
mod driver;
mod loads;

pub(crate) use craft::Craft;
pub(crate) use devices::{complete, doubts, gated};
pub(crate) use loads::Loads;
