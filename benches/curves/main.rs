//! How costs grow: with the tickets not at all, with the gates as stated.
//!
//! `cargo bench --bench curves`. Rows 7 and 8 of the targets in
//! `docs/performance.md`. What must not grow is shown twice: as a ratio of
//! times, in which caches have their say, and as a count of instructions, which
//! is equal or it is not.

mod count;
mod gates;
mod line;
mod many;
mod revoke;
mod stage;
#[path = "../support/mod.rs"]
mod support;

use std::process::ExitCode;

use count::{Case, Counts};
use support::{Bench, Failure, Target};

fn cases() -> Vec<Case> {
    let cases = revoke::cases().chain(many::cases()).chain(line::cases());
    cases.chain(gates::cases()).collect()
}

fn main() -> ExitCode {
    if let Some(done) = count::as_child(cases) {
        return done;
    }
    support::run("curves", |bench| {
        let counts = count::count()
            .inspect_err(|why| eprintln!("instructions are not counted: {why}"))
            .ok();
        let counts = counts.as_ref();
        revoke::measure(bench, counts)?;
        many::measure(bench, counts)?;
        line::measure(bench);
        instructions(bench, 8, "roster, 60 000 in line / 16", counts, &line::names())?;
        gates::measure(bench, counts)
    })
}

/// The ratio of two counts of instructions, each the most that was seen.
fn instructions(
    bench: &mut Bench,
    row: u8,
    name: &str,
    counts: Option<&Counts>,
    (large, small): &(String, String),
) -> Result<(), Failure> {
    let Some(counts) = counts else { return Ok(()) };
    let of = |name: &str| counts.of(name).ok_or_else(|| format!("{name} was not counted"));
    let (large, small) = (of(large)?, of(small)?);
    println!("{name}: {large:?} and {small:?}");
    let ratio = large.most as f64 / small.most as f64;
    bench.figure(row, &format!("{name}, instructions"), ratio, "x", Target::AtMost(1.0));
    Ok(())
}
