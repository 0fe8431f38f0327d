//! Occurrences by the time that they are due, with the most important one of
//! every subtree: "the most important that is due by now" is one walk from the
//! root, and nothing moves when something becomes due.
//!
//! A B-tree rather than a binary one: a look at a block of neighbours costs
//! hardly more than a look at one of them, so that a tree of 100 000 is three
//! looks deep where one of 100 is two.

use crate::manager::point::Micros;
use crate::manager::rank::Rank;

/// An occurrence in a tree. The order is that of time, then of importance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Item {
    /// When it is due.
    pub(crate) at: Micros,
    pub(crate) rank: Rank,
    /// Which task: an index of the manager's own.
    pub(crate) task: u32,
}

/// The most important occurrence of a part, with its task.
pub(crate) type Best = (Rank, u32);

#[derive(Clone, Debug)]
pub(crate) enum Tree {
    Leaf(Vec<Item>),
    Inner(Vec<Part>),
}

/// A subtree, which is never empty. All before `last` that is not before the
/// last of the part before is in it.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    last: Item,
    best: Best,
    tree: Tree,
}

/// The most neighbours in a block. Full ones are halved, empty ones dropped;
/// thin ones are not merged: what leaves does so mostly in the order of time,
/// from one end.
const BLOCK: usize = 64;

/// How many blocks were looked at.
pub(crate) type Looks = u64;

impl Default for Tree {
    fn default() -> Self {
        Self::Leaf(Vec::new())
    }
}

impl Tree {
    pub(crate) fn insert(&mut self, item: Item, looks: &mut Looks) {
        if let Some(second) = self.put(item, looks) {
            let first = core::mem::take(self);
            let parts = [first, second].into_iter().filter_map(Part::of);
            *self = Self::Inner(parts.collect());
        }
    }

    /// Answers the second half of a block that was full.
    fn put(&mut self, item: Item, looks: &mut Looks) -> Option<Self> {
        *looks = looks.wrapping_add(1);
        match self {
            Self::Leaf(items) => {
                let index = items.partition_point(|other| *other < item);
                items.insert(index, item);
                (items.len() > BLOCK).then(|| Self::Leaf(items.split_off(items.len() / 2)))
            }
            Self::Inner(parts) => {
                let index = parts.partition_point(|part| part.last < item);
                let index = index.min(parts.len().saturating_sub(1));
                let part = parts.get_mut(index)?;
                let second = part.tree.put(item, looks).and_then(Part::of);
                match second {
                    Some(second) => {
                        part.look_again();
                        parts.insert(index.saturating_add(1), second);
                    }
                    None => {
                        part.last = part.last.max(item);
                        part.best = part.best.min((item.rank, item.task));
                    }
                }
                (parts.len() > BLOCK).then(|| Self::Inner(parts.split_off(parts.len() / 2)))
            }
        }
    }

    /// Takes an item out, if it is there.
    pub(crate) fn remove(&mut self, item: &Item, looks: &mut Looks) {
        *looks = looks.wrapping_add(1);
        match self {
            Self::Leaf(items) => {
                if let Ok(index) = items.binary_search(item) {
                    items.remove(index);
                }
            }
            Self::Inner(parts) => {
                let index = parts.partition_point(|part| part.last < *item);
                let Some(part) = parts.get_mut(index) else { return };
                part.tree.remove(item, looks);
                if part.tree.is_empty() {
                    parts.remove(index);
                } else if part.last == *item || part.best == (item.rank, item.task) {
                    part.look_again();
                }
                if parts.len() == 1
                    && let Some(only) = parts.pop()
                {
                    *self = only.tree;
                }
            }
        }
    }

    /// The most important that is due by then.
    pub(crate) fn best_by(&self, at: Micros, looks: &mut Looks) -> Option<Best> {
        *looks = looks.wrapping_add(1);
        match self {
            Self::Leaf(items) => {
                let due = items.iter().take_while(|item| item.at <= at);
                due.map(|item| (item.rank, item.task)).min()
            }
            Self::Inner(parts) => {
                let whole = parts.partition_point(|part| part.last.at <= at);
                let (whole, rest) = parts.split_at_checked(whole)?;
                let best = whole.iter().map(|part| part.best).min();
                let more = rest.first().and_then(|part| part.tree.best_by(at, looks));
                best.into_iter().chain(more).min()
            }
        }
    }

    /// The first instant after this one at which something is due.
    pub(crate) fn next_after(&self, at: Micros, looks: &mut Looks) -> Option<Micros> {
        *looks = looks.wrapping_add(1);
        match self {
            Self::Leaf(items) => {
                let due = items.partition_point(|item| item.at <= at);
                items.get(due).map(|item| item.at)
            }
            Self::Inner(parts) => {
                let whole = parts.partition_point(|part| part.last.at <= at);
                parts.get(whole)?.tree.next_after(at, looks)
            }
        }
    }

    /// Those that are due at exactly this instant, most important first, but
    /// not more than so many.
    pub(crate) fn due_at(&self, at: Micros, most: usize, found: &mut Vec<u32>) {
        match self {
            Self::Leaf(items) => {
                let from = items.partition_point(|item| item.at < at);
                let due = items.iter().skip(from).take_while(|item| item.at == at);
                found.extend(due.take(most.saturating_sub(found.len())).map(|item| item.task));
            }
            Self::Inner(parts) => {
                let from = parts.partition_point(|part| part.last.at < at);
                for part in parts.iter().skip(from) {
                    let before = found.len();
                    part.tree.due_at(at, most, found);
                    if found.len() == before || found.len() >= most || part.last.at > at {
                        return;
                    }
                }
            }
        }
    }

    fn is_empty(&self) -> bool {
        match self {
            Self::Leaf(items) => items.is_empty(),
            Self::Inner(parts) => parts.is_empty(),
        }
    }

    fn last(&self) -> Option<Item> {
        match self {
            Self::Leaf(items) => items.last().copied(),
            Self::Inner(parts) => parts.last().map(|part| part.last),
        }
    }

    fn best(&self) -> Option<Best> {
        match self {
            Self::Leaf(items) => items.iter().map(|item| (item.rank, item.task)).min(),
            Self::Inner(parts) => parts.iter().map(|part| part.best).min(),
        }
    }
}

impl Part {
    fn of(tree: Tree) -> Option<Self> {
        Some(Self { last: tree.last()?, best: tree.best()?, tree })
    }

    fn look_again(&mut self) {
        if let (Some(last), Some(best)) = (self.tree.last(), self.tree.best()) {
            self.last = last;
            self.best = best;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::TaskPriority;
    use proptest::prelude::*;

    fn item(at: i64, level: u8, position: u32) -> Item {
        let priority = TaskPriority::new(level).unwrap();
        Item { at, rank: Rank::new(priority, at, position.into()), task: position }
    }

    proptest! {
        /// Against a plain list, whatever comes and goes.
        #[test]
        fn a_tree_answers_what_a_list_would(
            seeds in proptest::collection::vec((0..40_i64, 0..5_u8, any::<bool>(), 0..1_000_usize), 1..1_500),
            asked in 0..42_i64,
        ) {
            let (mut tree, mut list, mut looks) = (Tree::default(), Vec::new(), 0);
            for (n, (at, level, comes, which)) in seeds.into_iter().enumerate() {
                if comes || list.is_empty() {
                    let item = item(at, level, u32::try_from(n).unwrap());
                    tree.insert(item, &mut looks);
                    list.push(item);
                } else {
                    let item = list.swap_remove(which % list.len());
                    tree.remove(&item, &mut looks);
                }
            }
            list.sort_unstable();
            let due = list.iter().filter(|item| item.at <= asked);
            prop_assert_eq!(
                tree.best_by(asked, &mut looks),
                due.map(|item| (item.rank, item.task)).min()
            );
            let after = list.iter().find(|item| item.at > asked).map(|item| item.at);
            prop_assert_eq!(tree.next_after(asked, &mut looks), after);
            let mut found = Vec::new();
            tree.due_at(asked, 9, &mut found);
            let exactly = list.iter().filter(|item| item.at == asked).take(9);
            prop_assert_eq!(found, exactly.map(|item| item.task).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_tree_of_100_000_is_three_looks_deep() {
        let (mut tree, mut looks) = (Tree::default(), 0);
        for n in 0..100_000_u32 {
            // A permutation: 77 773 and 100 000 have no common divisor.
            let at = i64::from(n) * 77_773 % 100_000;
            let level = u8::try_from(n % 200).unwrap();
            tree.insert(item(at, level, n), &mut looks);
        }
        looks = 0;
        assert!(tree.best_by(50_000, &mut looks).is_some());
        assert!(looks <= 4, "{looks}");
    }
}
