//! What a step asks to be done at once.

use faregate_tickets::fault::GateFault;
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::standing::Why;

/// What is to be done at once, before the books are left. Whoever takes steps
/// keeps one, and hands it to each of them: it is too large to be passed around.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Actions<const G: usize> {
    /// Grants to revoke, by one increment each.
    pub revoked: List<(TicketId, Why), G>,
    /// Grants whose present epoch is to be explained, without an increment.
    pub explained: List<(TicketId, Why), G>,
    /// Grants that are over: to be revoked by one increment each, and their
    /// seats taken from them.
    pub ended: List<TicketId, G>,
    /// Tickets that became valid.
    pub granted: List<TicketId, G>,
    /// Devices that were seen off, or proved stuck.
    pub noted: List<Noted, G>,
}

/// What became of a device, for the flight recorder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Noted {
    /// Freshly seen off: its charge is credited.
    SeenOff(GateId),
    /// Made safe as often as declared, and not seen off.
    Stuck(GateId),
    /// Its gate became faulted.
    Faulted(GateId, GateFault),
}

impl<const G: usize> Actions<G> {
    /// Nothing to do.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            revoked: List::new(),
            explained: List::new(),
            ended: List::new(),
            granted: List::new(),
            noted: List::new(),
        }
    }

    /// Nothing to do any more.
    pub(super) fn clear(&mut self) {
        self.revoked.clear();
        self.explained.clear();
        self.ended.clear();
        self.granted.clear();
        self.noted.clear();
    }
}

/// One for each gate, and a few more: each revoked grant has a gate, but for
/// the ones that the events themselves name; of those whose time is over, as
/// many are ended in a step as there may be gates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct List<T, const G: usize> {
    gates: heapless::Vec<T, G>,
    more: heapless::Vec<T, 8>,
}

impl<T, const G: usize> List<T, G> {
    const fn new() -> Self {
        Self { gates: heapless::Vec::new(), more: heapless::Vec::new() }
    }

    /// In the order in which they came.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.gates.iter().chain(&self.more)
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.gates.len() + self.more.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.gates.is_empty()
    }

    /// Every step has room for what it asks for.
    pub(super) fn push(&mut self, item: T) {
        if let Err(item) = self.gates.push(item) {
            let _ = self.more.push(item);
        }
    }

    fn clear(&mut self) {
        self.gates.clear();
        self.more.clear();
    }
}

impl<T, const G: usize> Default for List<T, G> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'a, T, const G: usize> IntoIterator for &'a List<T, G> {
    type Item = &'a T;
    type IntoIter = core::iter::Chain<core::slice::Iter<'a, T>, core::slice::Iter<'a, T>>;

    fn into_iter(self) -> Self::IntoIter {
        self.gates.iter().chain(&self.more)
    }
}
