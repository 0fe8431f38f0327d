//! The one total order of importance.

use crate::manager::point::Micros;
use crate::task::TaskPriority;

/// Where an occurrence stands in the order. *Less is more important*: larger
/// priority, then earlier arrival, then earlier position in the schedule. No
/// two tasks have the same position, so no two ranks are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Rank {
    unimportance: u8,
    pub(crate) arrival: Micros,
    pub(crate) position: u64,
}

impl Rank {
    pub(crate) const fn new(priority: TaskPriority, arrival: Micros, position: u64) -> Self {
        Self { unimportance: u8::MAX - priority.level(), arrival, position }
    }
}
