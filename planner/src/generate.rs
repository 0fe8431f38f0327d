//! Plans of any size, drawn from a seed: for tests, benches and a first look.
//!
//! Two worlds. [`Shape::sols`] is a rover over as many sols as its activities
//! need, each as crowded as the others, so that costs can be compared over
//! sizes. [`Shape::small`] is some hours in steps of ten minutes, which an exact
//! solver can model, too.

mod activities;
mod small;
mod worlds;

use serde::{Deserialize, Serialize};

use crate::parameters::Parameters;
use crate::plan::Plan;
use crate::state::State;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// How many activities.
    pub activities: usize,
    /// How many of them in a sol; none: the small world.
    pub per_sol: Option<usize>,
    /// What activities draw, in percent of what is usual.
    pub draw: u64,
    /// Equal seeds draw equal plans.
    pub seed: u64,
}

/// A plan with its parameters and the state before it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct World {
    /// The plan.
    pub plan: Plan,
    /// Its parameters.
    pub parameters: Parameters,
    /// The state.
    pub state: State,
}

impl Shape {
    /// A hundred activities to a sol, of all types.
    #[must_use]
    pub const fn sols(activities: usize, seed: u64) -> Self {
        Self { activities, per_sol: Some(100), draw: 100, seed }
    }

    /// Some hours on a grid of ten minutes, with more activities than fit.
    #[must_use]
    pub const fn small(activities: usize, seed: u64) -> Self {
        Self { activities, per_sol: None, draw: 100, seed }
    }

    /// Of everything that it draws: what was worked out from a world elsewhere
    /// can tell whether it is the same one.
    #[must_use]
    pub fn checksum(self) -> u32 {
        crc32fast::hash(format!("{:?}", self.draw()).as_bytes())
    }

    /// Draws it.
    #[must_use]
    pub fn draw(self) -> World {
        match self.per_sol {
            Some(per_sol) => worlds::sols(self, per_sol.max(1)),
            None => small::small(self),
        }
    }
}
