//! Why an activity was left out, and the smallest change that lets it in.
//!
//! Each number by itself: everything else, and everything that had its turn
//! before, is as it was at the activity's turn. One unit less of the change,
//! and it would not be in. To relax a limit or a start range never takes a
//! valid start away, so there the change is the smallest that there is. A
//! manual shutdown that is shorter or at another time, and shorter heating,
//! move what the computer does, and a change somewhat smaller could help where
//! some larger one does not: such a one would not be found.
//!
//! Not looked at are the plan's end and the commit window: what changes them
//! changes the whole plan.

mod apply;
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
    /// What would let it in, each by itself, in the order of limits: with what
    /// is in the way of the earliest start, helped by a change of it or not.
    pub relaxations: Vec<Relaxation>,
    /// What had its place by then.
    pub beside: Vec<(ActivityId, Slot)>,
}

/// A limit that is in the way, by itself or among others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Relaxation {
    /// Which one.
    pub limit: Limit,
    /// The smallest change of one number with which there is a valid start;
    /// `None`: no change of one alone is enough.
    pub change: Option<Change>,
}

/// A change of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Which one.
    pub number: Number,
    /// By how much: millionths of the capacity for states of charge, bytes,
    /// mW, engines, the timeline's own unit, ms; 0 where there is no number.
    pub by: i64,
    /// The earliest start with it.
    pub start: Time,
    /// Who is in the way: holds it, is depended on, or is the shutdown.
    pub with: Option<ActivityId>,
    /// Until when what is in the way holds it.
    pub until: Option<Time>,
}

/// A number that can change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Number {
    /// The limit's own: a minimum of charge is lower, all others are higher.
    Limit,
    /// A timeline's smallest value is lower.
    Least(Whose),
    /// A timeline's largest value is higher.
    Most(Whose),
    /// A start range, by its index, opens earlier.
    From(usize),
    /// A start range, by its index, closes later.
    To(usize),
    /// A start range's cutoff, by its index, is later.
    Cutoff(usize),
    /// A manual shutdown is shorter.
    Shutdown(ActivityId),
    /// A manual shutdown begins earlier, with everything else where it is.
    Earlier(ActivityId),
    /// The same, later.
    Later(ActivityId),
    /// A zone is heated for a shorter time: the zone and the row of its table,
    /// by their indices in the parameters.
    Heating(usize, usize),
    /// Waking up takes less time.
    Wakeup,
    /// A sleep may be shorter.
    MinSleep,
    /// None: it would have to be without it.
    Without,
}

/// Who says which values of a timeline are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Whose {
    /// The parameters, at all times.
    Timeline,
    /// An activity while it runs: its constraint of this index.
    Constraint(ActivityId, usize),
}

/// Explains what became of a candidate at its turn. `None`: it is none.
///
/// # Timing
///
/// The pass up to its turn, and for each number some dozens of searches.
#[must_use]
pub fn explain(
    problem: &Problem,
    incumbent: Option<&TimedPlan>,
    id: ActivityId,
) -> Option<Explanation> {
    explain_all(problem, incumbent, |other| other == id).pop()
}

/// Explains what became of each of these candidates at its turn, in the order
/// of their turns.
///
/// # Timing
///
/// One pass, and for each number of each of them some dozens of searches.
pub fn explain_all(
    problem: &Problem,
    incumbent: Option<&TimedPlan>,
    mut wanted: impl FnMut(ActivityId) -> bool,
) -> Vec<Explanation> {
    let mut pass = Pass::new(problem, incumbent);
    let mut all = Vec::new();
    for &item in problem.order() {
        if wanted(pass.id(item)) {
            all.push(of(&mut pass, item));
        }
        pass.turn(item);
    }
    all
}

fn of(pass: &mut Pass<'_>, item: usize) -> Explanation {
    let turn = match pass.slots[item] {
        Some(slot) => Ok(slot),
        None => pass.find(item).map_err(|why| pass.reason(item, why)),
    };
    let relaxations = match &turn {
        Ok(_) | Err(Reason::GroupTaken(_)) => Vec::new(),
        Err(reason) => relax::all(pass, item, reason),
    };
    let beside = pass.slots.iter().enumerate();
    let beside = beside.filter_map(|(other, slot)| Some((pass.id(other), (*slot)?)));
    let beside = beside.collect();
    Explanation { id: pass.id(item), turn, relaxations, beside }
}
