//! What registers hold at each instruction, as far as it is settled before the
//! program runs: the depth of the stack, and numbers that are passed to calls.

use std::collections::{BTreeMap, BTreeSet};

use crate::body::{Body, Found, Node};
use crate::code::{Flow, Kind, Register, Value};
use crate::isa::Convention;

/// What a register can hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Holds {
    /// One of these numbers.
    OneOf(BTreeSet<u64>),
    /// An address on the stack, this many bytes from where the function found
    /// the stack pointer.
    Stack(i64),
}

/// What is known of the registers; of those that are not here, nothing.
pub type Registers = BTreeMap<Register, Holds>;

/// More numbers than that are as good as any.
const MANY: usize = 8;

/// The registers before each instruction, and where the stack is lost.
pub fn follow(body: &Body, convention: &Convention) -> (BTreeMap<u64, Registers>, Vec<Found>) {
    let mut before = BTreeMap::new();
    let mut found = BTreeSet::new();
    before.insert(body.entry, BTreeMap::from([(convention.stack_pointer, Holds::Stack(0))]));
    let mut open = vec![body.entry];
    while let Some(address) = open.pop() {
        let (Some(node), Some(registers)) = (body.nodes.get(&address), before.get(&address)) else {
            continue;
        };
        let after = after(node, registers, convention);
        if !node.follow.is_empty() && depth(&after, convention).is_none() {
            found.insert(Found::new(address, Kind::DynamicStack, "the stack pointer is lost here"));
            continue;
        }
        for next in &node.follow {
            let Some(known) = before.get_mut(next) else {
                before.insert(*next, after.clone());
                open.push(*next);
                continue;
            };
            if depth(known, convention) != depth(&after, convention) {
                let detail = format!("the stack grows on one of the ways to {next:#x}");
                found.insert(Found::new(address, Kind::DynamicStack, detail));
            } else if join(known, &after) {
                open.push(*next);
            }
        }
    }
    (before, found.into_iter().collect())
}

/// How many bytes the function has on the stack.
pub fn depth(registers: &Registers, convention: &Convention) -> Option<u64> {
    match registers.get(&convention.stack_pointer)? {
        Holds::Stack(offset) => u64::try_from(-offset).ok(),
        Holds::OneOf(_) => None,
    }
}

fn after(node: &Node, before: &Registers, convention: &Convention) -> Registers {
    let mut after = before.clone();
    let leaves = matches!(node.instruction.flow, Flow::Return);
    if leaves && node.instruction.conditional {
        // Where it goes on, it has done nothing.
        return after;
    }
    if matches!(node.instruction.flow, Flow::Call(_) | Flow::Kernel) {
        after.retain(|register, _| convention.kept.contains(register));
        return after;
    }
    for &(register, value) in &node.instruction.writes {
        match evaluate(value, before) {
            Some(holds) => after.insert(register, holds),
            None => after.remove(&register),
        };
    }
    after
}

fn evaluate(value: Value, before: &Registers) -> Option<Holds> {
    match value {
        Value::Constant(number) => Some(Holds::OneOf(BTreeSet::from([number]))),
        Value::Plus(from, more) => Some(match before.get(&from)? {
            Holds::Stack(offset) => Holds::Stack(offset + more),
            Holds::OneOf(numbers) => Holds::OneOf(
                numbers.iter().map(|number| number.wrapping_add_signed(more)).collect(),
            ),
        }),
        Value::And(from, mask) => match before.get(&from)? {
            // At most that much deeper: how much depends on the caller.
            Holds::Stack(offset) if is_alignment(mask) => {
                Some(Holds::Stack(offset - i64::try_from(!mask).ok()?))
            }
            Holds::Stack(_) => None,
            Holds::OneOf(numbers) => {
                Some(Holds::OneOf(numbers.iter().map(|number| number & mask).collect()))
            }
        },
        Value::Anything => None,
    }
}

fn is_alignment(mask: u64) -> bool {
    (!mask).wrapping_add(1).is_power_of_two()
}

/// Leaves what holds on both ways; whether that is less than before.
fn join(known: &mut Registers, other: &Registers) -> bool {
    let old = known.clone();
    known.retain(|register, holds| {
        let Some(also) = other.get(register) else { return false };
        match (holds, also) {
            (Holds::OneOf(numbers), Holds::OneOf(more)) => {
                numbers.extend(more);
                numbers.len() <= MANY
            }
            (holds, also) => holds == also,
        }
    });
    *known != old
}
