//! A value that changes at instants and is constant between them.

use std::collections::BTreeMap;

/// Changes at instants; sorted and summed when it is read.
#[derive(Clone, Debug, Default)]
pub(crate) struct Changes(BTreeMap<i64, i128>);

/// Values from instants on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Steps(Vec<(i64, i128)>);

impl Changes {
    /// So much more from `at` on.
    pub(crate) fn add(&mut self, at: i64, amount: i128) {
        *self.0.entry(at).or_default() += amount;
    }

    /// So much more over [start, end): nothing if that is empty.
    pub(crate) fn add_over(&mut self, start: i64, end: i64, amount: i128) {
        if start < end {
            self.add(start, amount);
            self.add(end, -amount);
        }
    }

    /// The values from `from` on, beginning with all that came before.
    pub(crate) fn from(&self, from: i64) -> Steps {
        let mut value = self.0.range(..=from).map(|(_, amount)| amount).sum();
        let mut steps = vec![(from, value)];
        for (at, amount) in self.0.range(from + 1..) {
            value += amount;
            steps.push((*at, value));
        }
        Steps(steps)
    }
}

impl Steps {
    /// The instants at which it may change.
    pub(crate) fn instants(&self) -> impl Iterator<Item = i64> {
        self.0.iter().map(|(at, _)| *at)
    }

    pub(crate) fn at(&self, at: i64) -> i128 {
        self.index(at).map_or(0, |i| self.0[i].1)
    }

    /// The pieces that cover [start, end): (from, to, value).
    pub(crate) fn pieces(&self, start: i64, end: i64) -> impl Iterator<Item = (i64, i64, i128)> {
        let first = self.index(start).unwrap_or(0);
        (first..self.0.len()).map_while(move |i| {
            let (at, value) = self.0[i];
            let next = self.0.get(i + 1).map_or(i64::MAX, |(next, _)| *next);
            let (from, to) = (at.max(start), next.min(end));
            (from < to).then_some((from, to, value))
        })
    }

    fn index(&self, at: i64) -> Option<usize> {
        self.0.partition_point(|(from, _)| *from <= at).checked_sub(1)
    }
}

/// Where a sum is past a limit, and further past it than in another world: the
/// first such instant in [from, to], and by how much.
pub(crate) fn first_past(
    with: &Steps,
    without: &Steps,
    limit: i128,
    (from, to): (i64, i64),
) -> Option<(i64, i128)> {
    let mut instants: Vec<i64> = with.instants().chain(without.instants()).collect();
    instants.push(from);
    instants.sort_unstable();
    instants.into_iter().filter(|at| (from..=to).contains(at)).find_map(|at| {
        let (value, before) = (with.at(at), without.at(at));
        (value > limit && value > before).then_some((at, value - limit))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_ends_where_the_next_begins() {
        let mut changes = Changes::default();
        changes.add_over(2, 5, 7);
        changes.add_over(4, 9, 1);
        changes.add_over(6, 6, 100);
        let steps = changes.from(0);
        let pieces: Vec<_> = steps.pieces(3, 8).collect();
        assert_eq!(pieces, [(3, 4, 7), (4, 5, 8), (5, 8, 1)]);
        assert_eq!((steps.at(1), steps.at(2), steps.at(9)), (0, 7, 0));
    }

    #[test]
    fn what_was_past_a_limit_before_does_not_count_unless_it_gets_worse() {
        let line = |amount| {
            let mut changes = Changes::default();
            changes.add_over(0, 10, amount);
            changes.from(0)
        };
        assert_eq!(first_past(&line(8), &line(8), 5, (0, 9)), None);
        assert_eq!(first_past(&line(9), &line(8), 5, (3, 9)), Some((3, 4)));
        assert_eq!(first_past(&line(5), &line(0), 5, (0, 9)), None);
    }
}
