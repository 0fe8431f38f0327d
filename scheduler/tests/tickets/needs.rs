//! Who asks, and for what.

use faregate_agents::Categories;
use faregate_scheduler::manager::{Attempt, Needs, Occurrence};
use faregate_scheduler::task::{TaskId, TaskPriority};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

/// The occurrence of the task of this number.
pub(crate) fn task(number: u32) -> Occurrence {
    Occurrence { task: TaskId::new(number).unwrap(), load: 0, number: 0 }
}

pub(crate) fn attempt(number: u32) -> Attempt {
    Attempt { occurrence: task(number), number: 1 }
}

pub(crate) fn needs(priority: u8) -> Needs {
    Needs {
        priority: TaskPriority::new(priority).unwrap(),
        categories: Categories::NONE,
        draw: Milliwatts::ZERO,
        gates: Vec::new(),
        grace: Duration::ZERO,
    }
}

pub(crate) trait Needing {
    fn using(self, category: u32) -> Needs;
    fn drawing(self, watts: u32) -> Needs;
    fn commanding(self, gates: &[&str]) -> Needs;
}

impl Needing for Needs {
    fn using(self, category: u32) -> Needs {
        Needs { categories: Categories::from_mask(1 << category), ..self }
    }
    fn drawing(self, watts: u32) -> Needs {
        Needs { draw: Milliwatts::from_watts(watts), ..self }
    }
    fn commanding(self, gates: &[&str]) -> Needs {
        Needs { gates: gates.iter().map(|gate| (*gate).to_owned()).collect(), ..self }
    }
}
