//! What the journal costs: records that survive, and opening it again.
//!
//! `cargo bench --bench journal`. Row 17 of the figures in
//! `docs/performance.md`. The peer is `redb`, an embedded database that is
//! crash-safe too.

mod compacting;
mod database;
mod opening;
mod records;
#[path = "../support/mod.rs"]
mod support;
mod writing;

use std::process::ExitCode;

use support::{Bench, Failure};

/// The row of its figures.
const ROW: u8 = 17;

fn main() -> ExitCode {
    support::run("journal", measure)
}

fn measure(bench: &mut Bench) -> Result<(), Failure> {
    writing::measure(bench)?;
    opening::measure(bench)?;
    compacting::measure(bench)
}
