//! The longest way through a function, when each instruction and each loop has
//! its cost.

use std::collections::{BTreeMap, BTreeSet};

use crate::body::Body;
use crate::loops::{Loop, Part, Region};

/// What is counted along a way, and how often loops turn.
pub trait Measure {
    /// What one instruction adds, with all that it calls.
    fn cost(&self, address: u64) -> u64;

    /// The most turns of a loop.
    fn turns(&self, of: &Loop) -> u64;
}

/// The most that any way from the entry can add up to.
pub fn longest(body: &Body, region: &Region, measure: &impl Measure) -> u64 {
    through(body, region, &BTreeSet::new(), measure).values().copied().max().unwrap_or(0)
}

/// For each instruction that is reached, the most when it has been executed.
fn through(
    body: &Body,
    region: &Region,
    also: &BTreeSet<u64>,
    measure: &impl Measure,
) -> BTreeMap<u64, u64> {
    // What has been added up before an instruction is executed.
    let entries = also.iter().chain([&region.entry]);
    let mut before: BTreeMap<_, _> = entries.map(|entry| (*entry, 0)).collect();
    let mut after = BTreeMap::new();
    for part in &region.parts {
        match part {
            Part::One(address) => {
                let Some(sum) = before.get(address) else { continue };
                after.insert(*address, measure.cost(*address).saturating_add(*sum));
            }
            Part::Loop(inner) => {
                let entries = inner.also.iter().chain([&inner.turn.entry]);
                let sum = entries.filter_map(|entry| before.get(entry).copied()).max();
                let Some(sum) = sum else { continue };
                around(body, inner, measure, sum, &mut after);
            }
        }
        for address in part.nodes() {
            let Some(sum) = after.get(&address).copied() else { continue };
            for next in body.nodes.get(&address).iter().flat_map(|node| &node.follow) {
                let known = before.entry(*next).or_insert(0);
                *known = sum.max(*known);
            }
        }
    }
    after
}

/// A loop: as many whole turns as it can make, and one way out. Whether it
/// looks before or after its body, this is enough. Where it can be entered in
/// the middle of a turn, that is one turn more.
fn around(
    body: &Body,
    inner: &Loop,
    measure: &impl Measure,
    sum: u64,
    after: &mut BTreeMap<u64, u64>,
) {
    let turn = through(body, &inner.turn, &inner.also, measure);
    let leads_back = |address: &u64| {
        body.nodes.get(address).is_some_and(|node| node.follow.contains(&inner.turn.entry))
    };
    let whole =
        turn.iter().filter(|(at, _)| leads_back(at)).map(|(_, sum)| *sum).max().unwrap_or(0);
    let begun = u64::from(!inner.also.is_empty());
    let turns = measure.turns(inner).saturating_add(begun);
    let turns = whole.saturating_mul(turns).saturating_add(sum);
    after.extend(turn.into_iter().map(|(at, way_out)| (at, turns.saturating_add(way_out))));
}

impl Part {
    fn nodes(&self) -> Vec<u64> {
        match self {
            Self::One(address) => vec![*address],
            Self::Loop(inner) => inner.nodes.iter().copied().collect(),
        }
    }
}

#[cfg(test)]
mod tests;
