//! Loops: the strongly connected parts of a function's graph, and those inside
//! them when the way back is cut.

use std::collections::BTreeSet;

use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;

use crate::body::Body;

/// A part of a graph that is entered at one instruction, with its loops taken
/// together.
#[derive(Debug)]
pub struct Region {
    /// Where it is entered.
    pub entry: u64,
    /// Its parts; each leads only to later ones.
    pub parts: Vec<Part>,
}

/// A part of a region.
#[derive(Debug)]
pub enum Part {
    /// One instruction.
    One(u64),
    /// A loop.
    Loop(Loop),
}

/// A loop.
#[derive(Debug)]
pub struct Loop {
    /// One turn of it: from its entry to where it leads back or out.
    pub turn: Region,
    /// All its instructions.
    pub nodes: BTreeSet<u64>,
    /// Where else it is entered, in the middle of a turn: compilers make such
    /// loops of two that share a tail. All ways round lead through the entry of
    /// `turn` or through an inner loop, so that turns are told apart there.
    pub also: BTreeSet<u64>,
}

impl Region {
    /// The regions of a function.
    pub fn of(body: &Body) -> Self {
        let all = body.nodes.keys().copied().collect();
        Self::within(body, body.entry, &all, false)
    }

    /// The region of `nodes`, entered at `entry`. In a loop the ways back to
    /// the entry are cut.
    fn within(body: &Body, entry: u64, nodes: &BTreeSet<u64>, in_loop: bool) -> Self {
        let mut graph = DiGraphMap::<u64, ()>::new();
        for &from in nodes {
            graph.add_node(from);
            for &to in body.nodes.get(&from).iter().flat_map(|node| &node.follow) {
                if nodes.contains(&to) && !(in_loop && to == entry) {
                    graph.add_edge(from, to, ());
                }
            }
        }
        // Tarjan's order is the reverse of what leads to what.
        let parts = tarjan_scc(&graph)
            .into_iter()
            .rev()
            .map(|part| match part.as_slice() {
                [one] if !graph.contains_edge(*one, *one) => Part::One(*one),
                _ => Part::Loop(Loop::of(body, &graph, entry, part.into_iter().collect())),
            })
            .collect();
        Self { entry, parts }
    }

    /// All loops in it, and those inside them, with how deep they are nested.
    pub fn loops(&self) -> Vec<&Loop> {
        let mut loops = Vec::new();
        for part in &self.parts {
            if let Part::Loop(inner) = part {
                loops.push(inner);
                loops.extend(inner.turn.loops());
            }
        }
        loops
    }
}

impl Loop {
    fn of(
        body: &Body,
        graph: &DiGraphMap<u64, ()>,
        region_entry: u64,
        nodes: BTreeSet<u64>,
    ) -> Self {
        let is_entered = |node: &u64| {
            *node == region_entry
                || graph
                    .neighbors_directed(*node, petgraph::Direction::Incoming)
                    .any(|from| !nodes.contains(&from))
        };
        let mut also: BTreeSet<_> = nodes.iter().copied().filter(is_entered).collect();
        let entry = also.pop_first().unwrap_or(region_entry);
        let turn = Region::within(body, entry, &nodes, true);
        Self { turn, nodes, also }
    }
}
