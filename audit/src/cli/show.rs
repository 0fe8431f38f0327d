//! `show`: the instructions that an audit of a function looks at.

use std::collections::BTreeSet;

use anyhow::{Result, ensure};
use faregate_audit::body::{Body, names};
use faregate_audit::code::Target;
use faregate_audit::image::{Function, Image};
use faregate_audit::loops::Region;

use super::Verdict;

/// Prints them.
pub(super) fn show(image: &Image, symbol: &str) -> Result<Verdict> {
    let mut open = image.named(symbol);
    ensure!(!open.is_empty(), "there is no function {symbol}");
    let mut shown = BTreeSet::new();
    while let Some(function) = open.pop() {
        if shown.insert(function.start) {
            open.extend(one(image, function)?);
        }
    }
    Ok(Verdict::Holds)
}

/// Prints one function; answers what it calls.
fn one<'a>(image: &'a Image, function: &Function) -> Result<Vec<&'a Function>> {
    println!("{} ({})", function.title(), function.names.join(", "));
    let (body, found) = Body::read(image, function)?;
    let region = Region::of(&body);
    let entries: BTreeSet<_> = region.loops().iter().map(|inner| inner.turn.entry).collect();
    let mut called = Vec::new();
    let mut source = None;
    for (address, node) in &body.nodes {
        let frames = image.frames(*address)?;
        let here = frames.last().map(|frame| format!("{} ({})", frame.function, frame.line));
        if here != source {
            println!("                ; {}", here.as_deref().unwrap_or("?"));
            source = here;
        }
        let mark = if entries.contains(address) { "loop:" } else { "" };
        let target = node.calls.as_ref().map(|target| format!("  -> {}", title(image, target)));
        let text = &node.instruction.text;
        println!("{mark:>6} {address:8x}  {text}{}", target.unwrap_or_default());
        if let Some(Target::At(start)) = &node.calls {
            called.extend(image.function(*start));
        }
    }
    for found in found {
        println!("  [{}] {}", found.kind, found.detail);
    }
    println!();
    Ok(called)
}

fn title(image: &Image, target: &Target) -> String {
    let name = names(image, target).into_iter().next();
    name.map_or_else(|| format!("{target:x?}"), |name| faregate_audit::image::path_of(&name))
}
