//! Rosters: who stands in line for a gate, the most important first.

use crate::limits::LEVELS;
use faregate_tickets::id::Priority;

/// No seat.
const NONE: u16 = u16::MAX;

/// One gate's line: 256 levels, each first in, first out, and a bitmap of the
/// levels that are not empty.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Line {
    occupied: [u64; LEVELS / 64],
    ends: [Ends; LEVELS],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Ends {
    first: u16,
    last: u16,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Link {
    next: u16,
    previous: u16,
}

/// The lines of all gates, linked through one arena: a seat stands in at most
/// one line.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Rosters<const G: usize, const T: usize> {
    lines: [Line; G],
    links: [Link; T],
}

impl Line {
    const EMPTY: Self =
        Self { occupied: [0; LEVELS / 64], ends: [Ends { first: NONE, last: NONE }; LEVELS] };

    /// The highest level that is not empty, by four leading-zero counts.
    fn highest(&self) -> Option<usize> {
        let [w0, w1, w2, w3] = self.occupied;
        let top =
            |word: u64, base: usize| (word != 0).then(|| base + 63 - word.leading_zeros() as usize);
        top(w3, 192).or(top(w2, 128)).or(top(w1, 64)).or(top(w0, 0))
    }

    fn mark(&mut self, level: usize, occupied: bool) {
        let bit = 1 << (level % 64);
        if let Some(word) = self.occupied.get_mut(level / 64) {
            *word = if occupied { *word | bit } else { *word & !bit };
        }
    }
}

impl<const G: usize, const T: usize> Rosters<G, T> {
    pub(crate) const fn new() -> Self {
        Self { lines: [Line::EMPTY; G], links: [Link { next: NONE, previous: NONE }; T] }
    }

    /// The most important seat in line for the gate, first come first.
    ///
    /// # Timing
    /// Constant, whatever stands in line: four leading-zero counts.
    pub(crate) fn first(&self, gate: usize) -> Option<usize> {
        let line = self.lines.get(gate)?;
        let ends = line.ends.get(line.highest()?)?;
        (ends.first != NONE).then_some(usize::from(ends.first))
    }

    /// Puts the seat at the end of its level.
    ///
    /// # Timing
    /// Constant, whatever stands in line.
    pub(crate) fn join(&mut self, gate: usize, priority: Priority, seat: u16) {
        let level = usize::from(priority.level());
        let Some(line) = self.lines.get_mut(gate) else { return };
        let Some(ends) = line.ends.get_mut(level) else { return };
        let previous = ends.last;
        ends.last = seat;
        if previous == NONE {
            ends.first = seat;
        }
        line.mark(level, true);
        self.relink(seat, Link { next: NONE, previous });
        self.set_next(previous, seat);
    }

    /// Takes the seat out of the line that it stands in.
    ///
    /// # Timing
    /// Constant, whatever stands in line.
    pub(crate) fn leave(&mut self, gate: usize, priority: Priority, seat: u16) {
        let level = usize::from(priority.level());
        let Some(&Link { next, previous }) = self.links.get(usize::from(seat)) else { return };
        self.set_next(previous, next);
        self.set_previous(next, previous);
        let Some(line) = self.lines.get_mut(gate) else { return };
        let Some(ends) = line.ends.get_mut(level) else { return };
        if ends.first == seat {
            ends.first = next;
        }
        if ends.last == seat {
            ends.last = previous;
        }
        let occupied = ends.first != NONE;
        line.mark(level, occupied);
        self.relink(seat, Link { next: NONE, previous: NONE });
    }

    fn relink(&mut self, seat: u16, link: Link) {
        if let Some(slot) = self.links.get_mut(usize::from(seat)) {
            *slot = link;
        }
    }

    fn set_next(&mut self, seat: u16, next: u16) {
        if let Some(link) = self.links.get_mut(usize::from(seat)) {
            link.next = next;
        }
    }

    fn set_previous(&mut self, seat: u16, previous: u16) {
        if let Some(link) = self.links.get_mut(usize::from(seat)) {
            link.previous = previous;
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn drain(rosters: &mut Rosters<2, 8>, priorities: &[u8; 8]) -> Vec<usize> {
        let mut order = Vec::new();
        while let Some(seat) = rosters.first(1) {
            order.push(seat);
            let level = Priority::new(priorities[seat]);
            rosters.leave(1, level, u16::try_from(seat).unwrap());
        }
        order
    }

    #[test]
    fn the_most_important_is_first_and_equals_are_first_come_first() {
        let mut rosters = Rosters::<2, 8>::new();
        let priorities = [5, 255, 5, 0, 64, 255, 63, 128];
        for (seat, level) in priorities.iter().enumerate() {
            rosters.join(1, Priority::new(*level), u16::try_from(seat).unwrap());
        }
        assert_eq!(rosters.first(0), None);
        assert_eq!(drain(&mut rosters, &priorities), [1, 5, 7, 4, 6, 0, 2, 3]);
        assert_eq!(rosters, Rosters::new());
    }

    #[test]
    fn leaving_from_the_middle_keeps_the_line() {
        let mut rosters = Rosters::<2, 8>::new();
        for seat in 0..5 {
            rosters.join(1, Priority::new(9), seat);
        }
        rosters.leave(1, Priority::new(9), 2);
        rosters.leave(1, Priority::new(9), 0);
        rosters.leave(1, Priority::new(9), 4);
        assert_eq!(drain(&mut rosters, &[9; 8]), [1, 3]);
    }
}
