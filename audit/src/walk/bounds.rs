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
            let most = self.most(inner, &owner, around, length)?;
            turns.insert(inner.turn.entry, most);
            around.push(owner);
            self.turns_in(analysis, &inner.turn, length, around, turns)?;
            around.pop();
        }
        Ok(())
    }

    fn most(
        &mut self,
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
