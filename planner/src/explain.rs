//! Why an activity was left out, and the smallest change that lets it in.
//!
//! Each limit by itself: everything else, and everything that had its turn
//! before, is as it was at the activity's turn. Relaxing one limit never takes
//! a valid start away, so the smallest change is found by halving, with the
//! same exact search as in the pass.

mod relax;

use crate::plan::ActivityId;
use crate::problem::Problem;
use crate::schedule::Pass;
use crate::timed::{Limit, Reason, Slot, TimedPlan};
use crate::units::Time;

/// Why an activity is where it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// Which one.
    pub id: ActivityId,
    /// What its turn came to: a slot, or what was in the way.
    pub turn: Result<Slot, Reason>,
    /// What would let it in, each by itself: in the order of limits.
    pub relaxations: Vec<Relaxation>,
}

/// A limit that is in the way, by itself or among others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Relaxation {
    /// Which one.
    pub limit: Limit,
    /// The smallest change of it with which there is a valid start; `None`:
    /// no change of it alone is enough.
    pub change: Option<Change>,
}

/// A change of one limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// By how much: millionths of the capacity for states of charge, bytes,
    /// mW, engines, ms. For bits and dependencies, which have no amount, 0: it
    /// would have to be without them.
    pub by: i64,
    /// The earliest start with it.
    pub start: Time,
    /// Who holds the bits, or is depended on.
    pub with: Option<ActivityId>,
    /// Which start range is changed.
    pub range: Option<usize>,
}

/// Explains what became of a candidate at its turn. `None`: it is none.
///
/// # Timing
///
/// The pass up to its turn, and for each limit some dozens of searches.
#[must_use]
pub fn explain(
    problem: &Problem,
    incumbent: Option<&TimedPlan>,
    id: ActivityId,
) -> Option<Explanation> {
    let mut pass = Pass::new(problem, incumbent);
    for &item in problem.order() {
        if pass.id(item) != id {
            pass.turn(item);
            continue;
        }
        if let Some(slot) = pass.slots[item] {
            return Some(Explanation { id, turn: Ok(slot), relaxations: Vec::new() });
        }
        let turn = pass.find(item);
        let relaxations = match &turn {
            Ok(_) | Err(Reason::GroupTaken(_)) => Vec::new(),
            Err(_) => relax::all(&pass, item),
        };
        return Some(Explanation { id, turn, relaxations });
    }
    None
}
