//! Why a plan, parameters and a state cannot be planned from.

use core::fmt;

use crate::plan::ActivityId;

/// Something that the plan, the parameters and the state do not agree on, or
/// that is out of bounds.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unfit {
    /// Two activities have this number.
    Twice(ActivityId),
    /// An activity has no start range.
    NoStart(ActivityId),
    /// An activity's duration, or its minimum, is negative, or the minimum is
    /// the longer one.
    Duration(ActivityId),
    /// An activity depends on one that there is not.
    Prior(ActivityId, ActivityId),
    /// An activity uses a thermal zone that the parameters do not know.
    Zone(ActivityId, String),
    /// An activity names a timeline that the parameters do not know.
    Timeline(ActivityId, String),
    /// The shutdown and the wakeup of a manual block do not fit into it.
    Block(ActivityId),
    /// Two manual blocks overlap.
    Blocks(ActivityId, ActivityId),
    /// An activity runs that the plan does not know.
    Running(ActivityId),
    /// An activity both runs and has ended, or is one of them twice.
    TwoStates(ActivityId),
    /// A preheat table's rows are not in order from 0 within the day.
    Table(String),
    /// This number of the parameters or the plan is out of bounds.
    OutOfBounds(&'static str),
    /// Amounts are so large that their sums could overflow.
    TooLarge(&'static str),
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Twice(id) => write!(f, "there are two of {id}: give one another number"),
            Self::NoStart(id) => write!(f, "{id} has no start range: it needs at least one"),
            Self::Duration(id) => write!(f, "{id}: 0 <= minimum <= duration does not hold"),
            Self::Prior(id, prior) => {
                write!(f, "{id} depends on {prior}, which is not in the plan")
            }
            Self::Zone(id, zone) => write!(f, "{id}: the parameters have no zone `{zone}`"),
            Self::Timeline(id, line) => write!(f, "{id}: the parameters have no timeline `{line}`"),
            Self::Block(id) => write!(f, "{id}: shutdown and wakeup are longer than the block"),
            Self::Blocks(one, other) => write!(f, "the shutdowns {one} and {other} overlap"),
            Self::Running(id) => write!(f, "{id} runs, and the plan does not know it"),
            Self::TwoStates(id) => write!(f, "the state has {id} more than once"),
            Self::Table(zone) => {
                write!(f, "zone `{zone}`: rows of its table are not in order, from 0, in a day")
            }
            Self::OutOfBounds(what) => write!(f, "{what} is out of bounds"),
            Self::TooLarge(what) => write!(f, "{what}: so large that sums could overflow"),
        }
    }
}

impl core::error::Error for Unfit {}
