//! Which bound of the row is which loop's.

use std::collections::BTreeMap;

use anyhow::Result;

use super::Walk;
use crate::analysis::Analysis;
use crate::body::Found;
use crate::code::Kind;
use crate::image::matches;
use crate::loops::{Loop, Part, Region};

impl Walk<'_> {
    /// The turns of each of the function's loops, by where it is entered.
    pub(super) fn turns(
        &mut self,
        analysis: &Analysis,
        length: Option<u64>,
    ) -> Result<BTreeMap<u64, u64>> {
        let mut turns = BTreeMap::new();
        self.turns_in(analysis, &analysis.region, length, &mut Vec::new(), &mut turns)?;
        Ok(turns)
    }

    fn turns_in(
        &mut self,
        analysis: &Analysis,
        region: &Region,
        length: Option<u64>,
        around: &mut Vec<String>,
        turns: &mut BTreeMap<u64, u64>,
    ) -> Result<()> {
        for part in &region.parts {
            let Part::Loop(inner) = part else { continue };
            let owner = analysis.owners.get(&inner.turn.entry).cloned().unwrap_or_default();
            let most = self.most(analysis, inner, &owner, around, length)?;
            turns.insert(inner.turn.entry, most);
            around.push(owner);
            self.turns_in(analysis, &inner.turn, length, around, turns)?;
            around.pop();
        }
        Ok(())
    }

    fn most(
        &mut self,
        analysis: &Analysis,
        inner: &Loop,
        owner: &str,
        around: &[String],
        length: Option<u64>,
    ) -> Result<u64> {
        if let Some(length) = length {
            // Each turn of a copy handles a byte at least.
            return Ok(length);
        }
        let depth = around.iter().filter(|outer| *outer == owner).count();
        let bounds = self.row.loops.iter().enumerate();
        let fitting = bounds
            .filter(|(_, bound)| matches(owner, &bound.within))
            .filter(|(_, bound)| bound.depth.is_none_or(|at| at == depth))
            .max_by_key(|(_, bound)| (bound.within.len(), bound.depth.is_some()));
        let exclusive = self.row.exclusive.as_ref().filter(|_| is_exclusive(analysis, inner));
        if let (None, Some(bound)) = (fitting, exclusive) {
            let (most, why) = (bound.most, bound.why.clone());
            self.outcome.loops.insert(("each exclusive access".to_owned(), most, why));
            return Ok(most);
        }
        let Some((at, bound)) = fitting else {
            let detail = format!("no bound is stated for this loop of {owner}, depth {depth}");
            self.report(&Found::new(inner.turn.entry, Kind::Loop, detail))?;
            return Ok(1);
        };
        self.outcome.bounds_used.insert(at);
        self.outcome.loops.insert((owner.to_owned(), bound.most, bound.why.clone()));
        Ok(bound.most)
    }
}

/// Whether the loop is one exclusive access and nothing else: a load, a store,
/// and what is done to the value between them.
fn is_exclusive(analysis: &Analysis, inner: &Loop) -> bool {
    let nodes: Vec<_> =
        inner.nodes.iter().filter_map(|address| analysis.body.nodes.get(address)).collect();
    let count =
        |name: &str| nodes.iter().filter(|node| node.instruction.text.starts_with(name)).count();
    let is_plain = inner.turn.loops().is_empty() && nodes.iter().all(|node| node.calls.is_none());
    is_plain && count("ldrex") == 1 && count("strex") == 1 && nodes.len() <= LONGEST_EXCLUSIVE
}

/// The most instructions of an exclusive access. The compiler's have up to
/// ten; a longer one is a loop of its own.
const LONGEST_EXCLUSIVE: usize = 16;
