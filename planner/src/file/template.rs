//! Files to begin with: a small sol with one activity of each type, and the
//! parameters and the state that it goes with.

/// The plan.
pub const PLAN: &str = include_str!("../../templates/plan.xml");
/// The parameters.
pub const PARAMETERS: &str = include_str!("../../templates/parameters.xml");
/// The state.
pub const STATE: &str = include_str!("../../templates/state.xml");
