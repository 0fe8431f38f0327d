//! Occurrences by the time that they are due, with the most important one of
//! every subtree: "the most important that is due by now" is one walk from the
//! root, and nothing moves when something becomes due.

use crate::manager::point::Micros;
use crate::manager::rank::Rank;

/// A tree, by its root. The nodes of all trees lie in one [`Arena`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tree(Link);

type Link = Option<u32>;

/// An occurrence in a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Item {
    /// When it is due.
    pub(crate) at: Micros,
    pub(crate) rank: Rank,
    /// Which task: an index of the manager's own.
    pub(crate) task: u32,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    item: Item,
    /// The most important of the subtree, with its task.
    best: (Rank, u32),
    /// A random number: no node has a larger one than its parent.
    height: u32,
    left: Link,
    right: Link,
}

/// The nodes of all trees.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arena {
    nodes: Vec<Node>,
    free: Vec<u32>,
    seed: u64,
    /// How many nodes were looked at.
    pub(crate) visits: u64,
}

impl Arena {
    pub(crate) fn insert(&mut self, tree: &mut Tree, item: Item) {
        let height = self.random();
        let node = Node { item, best: (item.rank, item.task), height, left: None, right: None };
        let Some(link) = self.place(node) else { return };
        tree.0 = self.insert_at(tree.0, link);
    }

    pub(crate) fn remove(&mut self, tree: &mut Tree, item: &Item) {
        tree.0 = self.remove_at(tree.0, item);
    }

    /// The most important that is due by then.
    pub(crate) fn best_by(&mut self, tree: Tree, at: Micros) -> Option<(Rank, u32)> {
        let mut best = None;
        let mut link = tree.0;
        let mut visits = 0;
        while let Some(node) = self.node(link) {
            visits += 1;
            link = if node.item.at <= at {
                best = least(best, Some((node.item.rank, node.item.task)));
                best = least(best, self.best(node.left));
                node.right
            } else {
                node.left
            };
        }
        self.visits = self.visits.wrapping_add(visits);
        best
    }

    /// The first instant after this one at which something is due.
    pub(crate) fn next_after(&mut self, tree: Tree, at: Micros) -> Option<Micros> {
        let mut next = None;
        let mut link = tree.0;
        let mut visits = 0;
        while let Some(node) = self.node(link) {
            visits += 1;
            link = if node.item.at > at {
                next = Some(node.item.at);
                node.left
            } else {
                node.right
            };
        }
        self.visits = self.visits.wrapping_add(visits);
        next
    }

    /// Those that are due at exactly this instant, most important first, but
    /// not more than so many.
    pub(crate) fn due_at(&self, tree: Tree, at: Micros, most: usize) -> Vec<u32> {
        let mut found = Vec::new();
        let mut stack = Vec::new();
        let mut link = tree.0;
        while found.len() < most {
            while let Some(index) = link {
                let Some(node) = self.node(link) else { break };
                if node.item.at >= at {
                    stack.push(index);
                    link = node.left;
                } else {
                    link = node.right;
                }
            }
            let Some(node) = stack.pop().and_then(|index| self.node(Some(index))) else { break };
            if node.item.at > at {
                break;
            }
            found.push(node.item.task);
            link = node.right;
        }
        found
    }

    fn insert_at(&mut self, root: Link, new: u32) -> Link {
        let (Some(index), Some(at), Some(node)) = (root, self.node(root), self.node(Some(new)))
        else {
            return Some(new);
        };
        let (before, higher, item) = (node.item < at.item, node.height > at.height, node.item);
        if higher {
            let (left, right) = self.split(root, &item);
            self.set(new, left, right);
            return Some(new);
        }
        let (left, right) = (at.left, at.right);
        if before {
            let left = self.insert_at(left, new);
            self.set(index, left, right);
        } else {
            let right = self.insert_at(right, new);
            self.set(index, left, right);
        }
        Some(index)
    }

    fn remove_at(&mut self, root: Link, item: &Item) -> Link {
        let index = root?;
        let node = *self.node(root)?;
        if node.item == *item {
            self.free.push(index);
            return self.merge(node.left, node.right);
        }
        if *item < node.item {
            let left = self.remove_at(node.left, item);
            self.set(index, left, node.right);
        } else {
            let right = self.remove_at(node.right, item);
            self.set(index, node.left, right);
        }
        Some(index)
    }

    /// Everything before the item, and everything from it on.
    fn split(&mut self, root: Link, item: &Item) -> (Link, Link) {
        let (Some(index), Some(node)) = (root, self.node(root).copied()) else {
            return (None, None);
        };
        if node.item < *item {
            let (middle, after) = self.split(node.right, item);
            self.set(index, node.left, middle);
            (root, after)
        } else {
            let (before, middle) = self.split(node.left, item);
            self.set(index, middle, node.right);
            (before, root)
        }
    }

    /// One tree of two, of which the first lies before the second.
    fn merge(&mut self, first: Link, second: Link) -> Link {
        let (Some(a), Some(b)) = (self.node(first).copied(), self.node(second).copied()) else {
            return first.or(second);
        };
        if a.height >= b.height {
            let right = self.merge(a.right, second);
            if let Some(index) = first {
                self.set(index, a.left, right);
            }
            first
        } else {
            let left = self.merge(first, b.left);
            if let Some(index) = second {
                self.set(index, left, b.right);
            }
            second
        }
    }

    /// Gives a node these children, and looks again for its subtree's best.
    fn set(&mut self, index: u32, left: Link, right: Link) {
        self.visits = self.visits.wrapping_add(1);
        let below = least(self.best(left), self.best(right));
        if let Some(node) = usize::try_from(index).ok().and_then(|index| self.nodes.get_mut(index))
        {
            let own = (node.item.rank, node.item.task);
            node.left = left;
            node.right = right;
            node.best = below.map_or(own, |below| below.min(own));
        }
    }

    fn best(&self, link: Link) -> Option<(Rank, u32)> {
        self.node(link).map(|node| node.best)
    }

    fn node(&self, link: Link) -> Option<&Node> {
        self.nodes.get(usize::try_from(link?).ok()?)
    }

    fn place(&mut self, node: Node) -> Link {
        if let Some(index) = self.free.pop() {
            *self.nodes.get_mut(usize::try_from(index).ok()?)? = node;
            return Some(index);
        }
        let index = u32::try_from(self.nodes.len()).ok()?;
        self.nodes.push(node);
        Some(index)
    }

    /// `SplitMix64`: what the shape of the trees depends on is the same in every
    /// run.
    fn random(&mut self) -> u32 {
        self.seed = self.seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.seed;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let [a, b, c, d, ..] = z.to_be_bytes();
        u32::from_be_bytes([a, b, c, d])
    }
}

fn least(a: Option<(Rank, u32)>, b: Option<(Rank, u32)>) -> Option<(Rank, u32)> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
