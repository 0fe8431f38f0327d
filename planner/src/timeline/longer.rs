//! Whether something that is inserted may last longer: compared with what it
//! does now, since others may have been placed because of that.

use super::Timelines;
use super::claim::{Claim, Touch};
use super::named::Outcome;
use super::starts::{FOREVER, Part};
use crate::units::Time;

impl Timelines {
    /// Whether `longer` can be in the place of `claim`, which began then and is
    /// inserted: nothing becomes worse between the one's end and the other's, or
    /// later. Data are not looked at.
    pub(crate) fn lengthens(&self, claim: &Claim, longer: &Claim, start: Time) -> bool {
        let end = start.after(claim.length());
        let more = claim.up_to(longer);
        let ends_later = longer.named.iter().all(|touch| {
            let Some(named) = self.named.get(touch.line) else { return true };
            let Outcome::Set(set) = &named.result else { return true };
            let setter = super::named::setter(touch, longer);
            set.can_end_later(setter, (start.get(), claim.length), &named.ranges())
        });
        ends_later && !self.valid_starts(&more, (end, end)).is_empty()
    }

    /// Ends in (from, last], in order and `last` among them. Of all ends between
    /// two of them it can have those from the first to the last that it can have
    /// there: nothing else happens there to what a claim changes at its end, so
    /// that what is added changes in a straight line.
    pub(crate) fn ends(&self, claim: &Claim, (from, last): (i64, i64)) -> Vec<i64> {
        let mut ends = vec![last];
        if claim.changes_at_its_end() {
            let first = from.saturating_sub(self.longest.0).saturating_sub(1);
            let near = self.placed.range((first, 0)..=(last.saturating_add(1), usize::MAX));
            let others = near.filter(|(_, other)| other.touches_lines_of(claim));
            let begins_and_ends =
                others.flat_map(|(&(start, _), other)| [start, start.saturating_add(other.length)]);
            // At that very instant the order in which things happen decides.
            ends.extend(begins_and_ends.flat_map(|at| [at - 1, at, at + 1]));
        }
        ends.retain(|&end| from < end && end <= last);
        ends.sort_unstable();
        ends.dedup();
        ends
    }
}

impl Claim {
    /// What is otherwise, from its end on, where it lasts as long as another: a
    /// claim that starts there.
    fn up_to(&self, longer: &Self) -> Self {
        let length = longer.length - self.length;
        let both = self.named.iter().zip(&longer.named);
        let named = both.map(|(now, then)| now.up_to(then, (self.length, length))).collect();
        Self { length, data: 0, limited: false, named, ..longer.clone() }
    }

    /// Whether it may do something at its end to a named timeline, besides giving
    /// back what it holds.
    fn changes_at_its_end(&self) -> bool {
        let gives_back = |touch: &Touch| touch.holds || touch.parts.is_empty();
        self.named.iter().any(|touch| touch.sets[1].is_some() || !gives_back(touch))
    }

    /// Whether it has to do with one of the named timelines of another one.
    fn touches_lines_of(&self, other: &Self) -> bool {
        let is_theirs = |line: usize| other.named.iter().any(|theirs| theirs.line == line);
        self.named.iter().any(|touch| is_theirs(touch.line))
    }
}

impl Touch {
    /// What a longer one adds to what this one did: as long as it goes on, and
    /// afterwards. `now` is this one's length, `more` by how much it grows.
    fn up_to(&self, longer: &Self, (now, more): (i64, i64)) -> Self {
        let (value, slope) = longer.during();
        let value = value + slope * i128::from(now) - self.stays();
        let during = Part { from: 0, to: more, value, slope };
        let value = longer.stays() - self.stays();
        let after = Part { from: more, to: FOREVER, value, slope: 0 };
        let parts = [during, after].into_iter().filter(Part::is_something).collect();
        // What it sets at its end comes later: that is looked at elsewhere.
        let keep = longer.keep.filter(|_| longer.sets[1].is_none());
        Self { line: longer.line, parts, holds: longer.holds, sets: [None; 2], keep }
    }
}
