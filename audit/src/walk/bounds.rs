//! Which bound of the row is which loop's.

use std::collections::BTreeMap;

use anyhow::Result;

use super::Walk;
use crate::body::{Body, Found};
use crate::code::Kind;
use crate::image::{Frame, matches};
use crate::loops::{Loop, Part, Region};

/// Crates whose functions hold loops for others: a loop in one of them is
/// named by who called it.
const LIBRARIES: &[&str] = &[
    "core", "alloc", "std", "heapless", "portable_atomic", "lock_api", "compiler_builtins",
];

/// Types whose traits are the libraries' too.
const PRIMITIVE: &[&str] = &[
    "u8", "u16", "u32", "u64", "u128", "usize", "i8", "i16", "i32", "i64", "i128", "isize", "bool",
    "char", "str", "f32", "f64",
];

impl Walk<'_> {
    /// The turns of each of the function's loops, by where it is entered.
    pub(super) fn turns(
        &mut self,
        body: &Body,
        region: &Region,
        length: Option<u64>,
    ) -> Result<BTreeMap<u64, u64>> {
        let mut turns = BTreeMap::new();
        self.turns_in(body, region, length, &mut Vec::new(), &mut turns)?;
        Ok(turns)
    }

    fn turns_in(
        &mut self,
        body: &Body,
        region: &Region,
        length: Option<u64>,
        around: &mut Vec<String>,
        turns: &mut BTreeMap<u64, u64>,
    ) -> Result<()> {
        for part in &region.parts {
            let Part::Loop(inner) = part else { continue };
            let owner = self.owner(body, inner)?;
            let most = self.most(inner, &owner, around, length)?;
            turns.insert(inner.turn.entry, most);
            around.push(owner);
            self.turns_in(body, &inner.turn, length, around, turns)?;
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

    /// The function of the source that all of the loop is in: the innermost
    /// that is no library's.
    fn owner(&self, body: &Body, inner: &Loop) -> Result<String> {
        let mut common: Option<Vec<Frame>> = None;
        for address in own(inner) {
            let frames = self.image.frames(address)?;
            // What the optimiser made of two lines has no line, and stands in
            // a function further out.
            if frames.last().is_none_or(|frame| frame.line.ends_with(":0")) {
                continue;
            }
            let shared = match common {
                None => frames,
                Some(known) => known
                    .into_iter()
                    .zip(frames)
                    .take_while(|(a, b)| a.function == b.function)
                    .map(|(a, _)| a)
                    .collect(),
            };
            common = Some(shared);
        }
        let frames = common.unwrap_or_default();
        let is_own = |frame: &&Frame| !is_library(&frame.function);
        let owner = frames.iter().rev().find(is_own).or(frames.last());
        let symbol = body.nodes.get(&body.entry).and_then(|_| self.image.function(body.entry));
        Ok(owner.map(|frame| frame.function.clone()).or(symbol.map(|it| it.title())).unwrap_or_default())
    }
}

/// Whether the function belongs to a library, or to a type of the language.
fn is_library(path: &str) -> bool {
    let root = path.split("::").next().unwrap_or_default();
    let of_language = root != path && root.starts_with(|letter: char| !letter.is_alphabetic());
    LIBRARIES.contains(&root) || PRIMITIVE.contains(&root) || of_language
}

/// The loop's instructions that are in none of its inner loops.
fn own(of: &Loop) -> Vec<u64> {
    let one = |part: &Part| match part {
        Part::One(address) => Some(*address),
        Part::Loop(_) => None,
    };
    of.turn.parts.iter().filter_map(one).collect()
}
