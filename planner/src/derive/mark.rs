//! Where a sweep can go on, and where two worlds can be compared.

use crate::energy::Cursor;

use super::var::Var;

/// The computer is up, from waking up to shut down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Phase {
    pub(crate) wakeup: Var,
    pub(crate) up: Var,
    pub(crate) down: Var,
    pub(crate) asleep: Var,
}

/// A phase's begin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Up {
    pub(crate) wakeup: Var,
    pub(crate) up: Var,
    /// Awake time counts from then on.
    pub(crate) counted: Var,
}

/// The computer has just fallen asleep: a sweep can go on from there, and two
/// worlds can be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mark {
    pub(crate) cursor: Cursor,
    /// How many needs of what is placed are met.
    pub(crate) met: usize,
    /// How many phases are over.
    pub(crate) phases: usize,
}

impl Mark {
    /// Whether the same of what is placed is behind, at the same instant, where
    /// there are so many more changes and needs.
    pub(crate) fn is_beside(&self, other: &Self, more: (isize, isize)) -> bool {
        self.met.checked_add_signed(more.1) == Some(other.met)
            && self.cursor.is_beside(&other.cursor, more.0)
    }

    /// The same later in a world that goes on as this one does, from `here` in
    /// this one and `there` in that one.
    pub(crate) fn carried(&self, here: &Self, there: &Self, more: (isize, isize)) -> Self {
        let change = there.cursor.charge.minus(here.cursor.charge);
        let mut mark = self.changed(change, more);
        mark.cursor = mark.cursor.with_cuts(here.cursor.cuts, there.cursor.cuts);
        mark.phases = self.phases + there.phases - here.phases;
        mark
    }

    /// The same where there is so much more charge, and so many more changes and
    /// needs.
    pub(crate) fn changed(&self, charge: Var, more: (isize, isize)) -> Self {
        let cursor = self.cursor.changed(charge, more.0);
        Self { cursor, met: self.met.saturating_add_signed(more.1), ..*self }
    }
}

/// Where a sweep goes on after a mark.
#[derive(Clone, Copy, Debug)]
pub(crate) enum After {
    /// With the sleep that has just begun.
    On,
    /// With a later one: what lies between is known.
    From(Mark),
    /// Nowhere: all that follows is known.
    Over,
}

/// A phase that has not ended: the needs that are met so far keep the computer
/// up until then, and this has happened by the cursor's instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Open {
    pub(crate) begun: Up,
    pub(crate) until: Var,
    pub(crate) cursor: Cursor,
    pub(crate) met: usize,
    pub(crate) phases: usize,
}
