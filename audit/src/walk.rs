//! The audit of one row: its function and all that it calls.

mod bounds;
mod calls;

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;

use crate::analysis::Analysis;
use crate::body::{Body, Found};
use crate::code::{Flow, Instruction, Kind, Value};
use crate::image::{Function, Image};
use crate::isa::Convention;
use crate::longest::{Measure, longest};
use crate::loops::Loop;
use crate::rows::Row;
use crate::values::{Registers, depth};

/// What the audit found in a row's function, for one object.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Outcome {
    /// The longest path, in instructions.
    pub instructions: u64,
    /// The most locked instructions on any path.
    pub locked: u64,
    /// The deepest stack, in bytes.
    pub stack: u64,
    /// Its loops, each once: the function of the source, the turns, what is counted.
    pub loops: BTreeSet<(String, u64, String)>,
    /// The longest copy, fill or comparison, in bytes.
    pub copies: Option<u64>,
    /// Where the walk stopped.
    pub cold: BTreeSet<String>,
    /// The system calls on its paths.
    pub system_calls: BTreeSet<String>,
    /// What it calls in other objects.
    pub external: BTreeSet<String>,
    /// Why it calls what memory says, where it does.
    pub port: Option<String>,
    /// What its row excuses, with the reasons.
    pub excused: BTreeSet<String>,
    /// What is wrong with it.
    pub violations: Vec<Violation>,
    /// The bounds of the row that found their loops, by their place in it.
    #[serde(skip)]
    pub bounds_used: BTreeSet<usize>,
    /// All instructions that it can execute.
    #[serde(skip)]
    pub reached: BTreeSet<u64>,
}

impl Outcome {
    /// The kinds of things that are wrong with it.
    pub fn kinds(&self) -> BTreeSet<String> {
        self.violations.iter().map(|violation| violation.kind.clone()).collect()
    }
}

/// Something that no row may have unless it says so.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Violation {
    /// The kind's name.
    pub kind: String,
    /// Symbol and offset.
    pub place: String,
    /// The instruction.
    pub text: String,
    /// Where it stands in the source, the innermost function first.
    pub source: Vec<String>,
    /// In words.
    pub detail: String,
}

/// What a call of a function costs.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    instructions: u64,
    locked: u64,
    stack: u64,
}

impl Cost {
    fn or_more(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.max(other.instructions),
            locked: self.locked.max(other.locked),
            stack: self.stack.max(other.stack),
        }
    }
}

/// The walk through a closed call graph.
struct Walk<'a> {
    image: &'a Image,
    convention: Convention,
    row: &'a Row,
    outcome: Outcome,
    /// What is known of functions, those apart that are being walked now. A
    /// copy is another one for each length.
    known: BTreeMap<(u64, Option<u64>), Cost>,
    /// The functions that are being walked.
    inside: Vec<u64>,
}

/// Audits the row's function in the object.
///
/// # Errors
/// Where the object cannot be read; what is wrong with the *function* is in
/// the outcome.
pub fn audit(image: &Image, row: &Row) -> Result<Outcome> {
    let mut walk = Walk {
        image,
        convention: image.isa.convention(),
        row,
        outcome: Outcome::default(),
        known: BTreeMap::new(),
        inside: Vec::new(),
    };
    let functions = image.named(&row.symbol);
    if functions.is_empty() {
        let detail = format!("there is no function {}", row.symbol);
        walk.outcome.violations.push(Violation::nowhere(Kind::Missing, &row.symbol, detail));
    }
    let mut worst = Cost::default();
    for function in functions {
        worst = worst.or_more(walk.function(function, None)?);
        walk.look_for_emptiness(function)?;
    }
    let mut outcome = walk.outcome;
    outcome.instructions = worst.instructions;
    outcome.locked = worst.locked;
    // Its own return address stands on the stack too.
    outcome.stack = worst.stack + image.isa.convention().return_address;
    Ok(outcome)
}

impl Walk<'_> {
    /// The cost of a function, which is entered with `length` if it copies.
    fn function(&mut self, function: &Function, length: Option<u64>) -> Result<Cost> {
        if let Some(known) = self.known.get(&(function.start, length)) {
            return Ok(*known);
        }
        self.inside.push(function.start);
        let cost = self.walk(function, length);
        self.inside.pop();
        let cost = cost?;
        self.known.insert((function.start, length), cost);
        Ok(cost)
    }

    fn walk(&mut self, function: &Function, length: Option<u64>) -> Result<Cost> {
        let analysis = Analysis::of(self.image, function)?;
        let (body, registers) = (&analysis.body, &analysis.registers);
        for found in &analysis.found {
            self.report(found)?;
        }
        self.outcome.reached.extend(body.nodes.keys());
        let mut costs = BTreeMap::new();
        for address in body.nodes.keys() {
            let known = registers.get(address).cloned().unwrap_or_default();
            costs.insert(*address, self.instruction(body, *address, &known, length)?);
        }
        let turns = self.turns(&analysis, length)?;
        let along = |of: fn(&Cost) -> u64| {
            longest(body, &analysis.region, &Along { costs: &costs, turns: &turns, of })
        };
        Ok(Cost {
            instructions: along(|cost| cost.instructions),
            locked: along(|cost| cost.locked),
            stack: costs.values().map(|cost| cost.stack).max().unwrap_or(0),
        })
    }

    /// One instruction, with what it calls.
    fn instruction(
        &mut self,
        body: &Body,
        address: u64,
        registers: &Registers,
        length: Option<u64>,
    ) -> Result<Cost> {
        let Some(node) = body.nodes.get(&address) else { return Ok(Cost::default()) };
        let instruction = &node.instruction;
        if let Some(kind) = instruction.breaks {
            self.report(&Found::new(address, kind, ""))?;
        }
        if instruction.flow == Flow::Kernel {
            self.kernel(address, self.convention.system_call, registers)?;
        }
        let here = depth(registers, &self.convention).unwrap_or(0);
        let mut cost = Cost { instructions: 1, locked: instruction.locked.into(), stack: here };
        if let Some(target) = &node.calls {
            let called = self.called(address, node, target, registers, length)?;
            let link = if node.is_tail { 0 } else { self.convention.return_address };
            cost.instructions = called.instructions.saturating_add(1);
            cost.locked = cost.locked.saturating_add(called.locked);
            cost.stack = here.saturating_add(link).saturating_add(called.stack);
        }
        Ok(cost)
    }

    fn report(&mut self, found: &Found) -> Result<()> {
        if self.is_excused(found.kind) {
            return Ok(());
        }
        let violation = Violation::at(self.image, found)?;
        if !self.outcome.violations.contains(&violation) {
            self.outcome.violations.push(violation);
        }
        Ok(())
    }

    /// Whether the row says that this may be, and why; it is noted if so.
    fn is_excused(&mut self, kind: Kind) -> bool {
        let name = format!("{kind}: ");
        let excuse = self.row.may.iter().find(|may| may.starts_with(&name));
        self.outcome.excused.extend(excuse.cloned());
        excuse.is_some()
    }

    /// A function that does nothing shows nothing: the shim was optimised away.
    fn look_for_emptiness(&mut self, function: &Function) -> Result<()> {
        let analysis = Analysis::of(self.image, function)?;
        let mut all = analysis.body.nodes.values();
        if !analysis.body.nodes.is_empty() && all.all(|node| is_idle(&node.instruction)) {
            self.report(&Found::new(function.start, Kind::Empty, "it does nothing"))?;
        }
        Ok(())
    }
}

/// Whether the instruction only returns, or puts into registers what is settled.
fn is_idle(instruction: &Instruction) -> bool {
    let is_settled = |(_, value): &(_, Value)| *value != Value::Anything;
    let fills = ["nop", "endbr", "pop"].iter().any(|name| instruction.text.starts_with(name));
    let settled = !instruction.writes.is_empty() && instruction.writes.iter().all(is_settled);
    match instruction.flow {
        Flow::Return => true,
        Flow::On => fills || settled,
        _ => false,
    }
}

impl Violation {
    fn nowhere(kind: Kind, place: &str, detail: String) -> Self {
        let place = place.to_owned();
        Self { kind: kind.to_string(), place, text: String::new(), source: Vec::new(), detail }
    }

    fn at(image: &Image, found: &Found) -> Result<Self> {
        let text = match image.function_around(found.address) {
            Some(function) => image
                .decode(function)?
                .into_iter()
                .find(|instruction| instruction.address == found.address)
                .map_or_else(String::new, |instruction| instruction.text),
            None => String::new(),
        };
        let frames = image.frames(found.address)?;
        let source =
            frames.iter().rev().map(|frame| format!("{} ({})", frame.function, frame.line));
        Ok(Self {
            kind: found.kind.to_string(),
            place: image.place(found.address),
            text,
            source: source.collect(),
            detail: found.detail.clone(),
        })
    }
}

/// One of the sums along the longest way.
struct Along<'a> {
    costs: &'a BTreeMap<u64, Cost>,
    turns: &'a BTreeMap<u64, u64>,
    of: fn(&Cost) -> u64,
}

impl Measure for Along<'_> {
    fn cost(&self, address: u64) -> u64 {
        self.costs.get(&address).map_or(0, self.of)
    }

    fn turns(&self, of: &Loop) -> u64 {
        self.turns.get(&of.turn.entry).copied().unwrap_or(1)
    }
}
