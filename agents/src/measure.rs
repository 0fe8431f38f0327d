//! The rosters by themselves, for whoever audits or measures them.

use faregate_tickets::id::Priority;

use crate::roster::Rosters;

/// The lines of `G` gates, for `T` seats.
#[derive(Clone, Debug)]
pub struct Lines<const G: usize, const T: usize>(Rosters<G, T>);

impl<const G: usize, const T: usize> Lines<G, T> {
    /// Nobody stands in line.
    #[must_use]
    pub const fn new() -> Self {
        Self(Rosters::new())
    }

    /// The most important seat in line for the gate, first come first.
    #[must_use]
    pub fn first(&self, gate: usize) -> Option<usize> {
        self.0.first(gate)
    }

    /// Puts a seat, which stands in no line, at the end of its level.
    pub fn join(&mut self, gate: usize, priority: Priority, seat: u16) {
        self.0.join(gate, priority, seat);
    }

    /// Takes a seat out of the line that it stands in.
    pub fn leave(&mut self, gate: usize, priority: Priority, seat: u16) {
        self.0.leave(gate, priority, seat);
    }
}

impl<const G: usize, const T: usize> Default for Lines<G, T> {
    fn default() -> Self {
        Self::new()
    }
}
