//! What is broken about an execution, so that a checker can be seen to find it.

use std::sync::Arc;

use faregate_planner::{Parameters, Plan};

/// What is broken: nothing, unless a test wants it.
///
/// A control thread with a limit that is one off does what a right one would do
/// that was told another limit. So it is told one, and whoever plans and whoever
/// checks are not.
#[derive(Clone, Debug, Default)]
pub struct Breaks {
    /// What the control thread believes instead.
    pub believes: Option<Belief>,
    /// What is paused goes on without tickets, until somebody needs its devices.
    pub goes_on: bool,
}

/// What a control thread believes.
#[derive(Clone, Debug)]
pub struct Belief {
    /// Instead of the plan.
    pub plan: Arc<Plan>,
    /// Instead of the parameters.
    pub parameters: Arc<Parameters>,
}
