//! One function's instructions as a graph: those that its entry leads to.

use std::collections::BTreeMap;

use anyhow::Result;

use crate::code::{Flow, Instruction, Kind, Target};
use crate::image::{Function, Image, Role, role_of};

/// A function's graph.
#[derive(Debug)]
pub struct Body {
    /// Where it is entered.
    pub entry: u64,
    /// Every instruction that can be reached, by address.
    pub nodes: BTreeMap<u64, Node>,
}

/// An instruction in the graph.
#[derive(Debug)]
pub struct Node {
    /// What it is.
    pub instruction: Instruction,
    /// The instructions of the same function that can follow it.
    pub follow: Vec<u64>,
    /// What it calls. A jump out of the function is a call that does not
    /// return to it.
    pub calls: Option<Target>,
    /// Whether that call is such a jump.
    pub is_tail: bool,
}

/// Something found at an address.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Found {
    /// Where.
    pub address: u64,
    /// What.
    pub kind: Kind,
    /// In words, where the kind does not say it all.
    pub detail: String,
}

impl Found {
    /// Of an instruction.
    pub fn new(address: u64, kind: Kind, detail: impl Into<String>) -> Self {
        Self { address, kind, detail: detail.into() }
    }
}

impl Body {
    /// The graph of `function`, and where it leads nowhere.
    ///
    /// # Errors
    /// Where its bytes are no instructions.
    pub fn read(image: &Image, function: &Function) -> Result<(Self, Vec<Found>)> {
        let read: BTreeMap<_, _> = image
            .decode(function)?
            .into_iter()
            .map(|instruction| (instruction.address, instruction))
            .collect();
        let mut body = Self { entry: function.start, nodes: BTreeMap::new() };
        let mut found = Vec::new();
        if read.is_empty() {
            found.push(Found::new(function.start, Kind::Empty, "there is no instruction in it"));
            return Ok((body, found));
        }
        let mut open = vec![(function.start, function.start)];
        while let Some((address, from)) = open.pop() {
            if body.nodes.contains_key(&address) {
                continue;
            }
            let Some(instruction) = read.get(&address) else {
                let detail = format!("leads to {address:#x}, where no instruction begins");
                found.push(Found::new(from, Kind::Unknown, detail));
                continue;
            };
            let node = Node::new(image, function, instruction.clone());
            open.extend(node.follow.iter().map(|&next| (next, address)));
            body.nodes.insert(address, node);
        }
        Ok((body, found))
    }
}

impl Node {
    fn new(image: &Image, function: &Function, instruction: Instruction) -> Self {
        let mut node = Self { instruction, follow: Vec::new(), calls: None, is_tail: false };
        let goes_on = node.instruction.conditional;
        let next = node.instruction.next;
        match node.instruction.flow.clone() {
            Flow::On | Flow::Kernel => node.follow.push(next),
            Flow::Return | Flow::Trap => {}
            Flow::Call(target) => {
                let ends_here = next >= function.end && !comes_back(image, &target);
                if !ends_here && !never_returns(image, &target) {
                    node.follow.push(next);
                }
                node.calls = Some(target);
            }
            Flow::Jump(Target::At(to)) if (function.start..function.end).contains(&to) => {
                node.follow.push(to);
            }
            Flow::Jump(target) => {
                node.calls = Some(target);
                node.is_tail = true;
            }
        }
        if goes_on && !node.follow.contains(&next) {
            node.follow.push(next);
        }
        node
    }
}

/// What comes after such a call is another branch's code, or nothing.
fn never_returns(image: &Image, target: &Target) -> bool {
    names(image, target).iter().any(|name| role_of(name) == Some(Role::Denied(Kind::Panic)))
}

/// Whether some path through what is called returns. Asked only where nothing
/// follows the call.
fn comes_back(image: &Image, target: &Target) -> bool {
    let Target::At(address) = target else { return true };
    let Some(Ok((body, _))) = image.function(*address).map(|function| Body::read(image, function))
    else {
        return true;
    };
    body.nodes.values().any(|node| node.is_tail || node.instruction.flow == Flow::Return)
}

/// All names of what is called.
pub fn names(image: &Image, target: &Target) -> Vec<String> {
    match target {
        Target::At(address) => {
            image.function(*address).map(|function| function.names.clone()).unwrap_or_default()
        }
        Target::Outside(name) => vec![name.clone()],
        Target::Held(_) | Target::Computed => Vec::new(),
    }
}
