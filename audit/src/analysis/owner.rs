//! In which function of the source a loop stands.

use anyhow::Result;

use crate::image::{Frame, Function, Image};
use crate::loops::{Loop, Part};

/// Crates whose functions hold loops for others: a loop in one of them is
/// named by who called it.
const LIBRARIES: &[&str] =
    &["core", "alloc", "std", "heapless", "portable_atomic", "lock_api", "compiler_builtins"];

/// Types whose traits are the libraries' too.
const PRIMITIVE: &[&str] = &[
    "u8", "u16", "u32", "u64", "u128", "usize", "i8", "i16", "i32", "i64", "i128", "isize", "bool",
    "char", "str", "f32", "f64",
];

/// The function of the source that all of the loop is in: the innermost that is
/// no library's.
pub(super) fn owner(image: &Image, function: &Function, inner: &Loop) -> Result<String> {
    let mut common: Option<Vec<Frame>> = None;
    for address in own(inner) {
        let frames = image.frames(address)?;
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
    Ok(owner.map_or_else(|| function.title(), |frame| frame.function.clone()))
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
