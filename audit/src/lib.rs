//! The static bounded-time audit of the compiled code.
//!
//! A row of `rows.toml` names a function of a linked object. The audit builds
//! the graph of its instructions and of all that it calls, and looks for what
//! has no bound: loops without a stated one, recursion, calls and jumps that
//! memory decides, divisions, panics, allocations, system calls, a stack that
//! grows as the data does. What is left has a longest path, which is printed.
//!
//! Nothing is taken from the source but names: what is judged is what runs.
//!
//! | module | what |
//! |---|---|
//! | [`rows`] | what is audited, and what is allowed there |
//! | [`image`] | a linked object: functions, relocations, debug information |
//! | [`isa`], [`code`] | instruction sets, and what they have in common |
//! | [`body`], [`values`], [`loops`], [`longest`] | one function: graph, registers, loops, longest path |
//! | [`analysis`] | these together, done once for each function |
//! | [`walk`] | a row: the closed call graph, and what is wrong with it |
//! | [`findings`] | all rows, on all objects |
//! | [`items`] | which public items promise constant time, and which row shows it |
//! | [`table`] | the table in `docs/timing.md` |
//! | `step` | random calls, single-stepped, against the bounds (Linux on x86-64) |

pub mod analysis;
pub mod body;
pub mod code;
pub mod findings;
pub mod image;
pub mod isa;
pub mod items;
pub mod longest;
pub mod loops;
pub mod rows;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
pub mod step;
pub mod table;
pub mod values;
pub mod walk;
