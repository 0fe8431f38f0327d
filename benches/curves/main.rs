//! How costs grow: with the tickets not at all, with the gates as stated.
//!
//! `cargo bench --bench curves`. Rows 7 and 8 of the targets in
//! `docs/performance.md`. What must not grow is shown twice: as a ratio of
//! times, in which caches have their say, and as a count of instructions, which
//! is equal or it is not.

mod bars;
mod count;
mod gates;
mod line;
mod many;
mod revoke;
mod stage;
#[path = "../support/mod.rs"]
mod support;

use std::cell::RefCell;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Duration;

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
        let counts =
            count::count().inspect_err(|why| eprintln!("instructions are not counted: {why}")).ok();
        let counts = counts.as_ref();
        revoke::measure(bench, counts)?;
        many::measure(bench, counts)?;
        line::measure(bench);
        instructions(bench, 8, "roster, 60 000 in line / 16", counts, &line::names())?;
        bars::measure(bench)?;
        gates::measure(bench, counts)
    })
}

/// The first failure of a contest, whose entrants can only answer times.
#[derive(Clone, Default)]
struct Failed(Rc<RefCell<Option<Failure>>>);

impl Failed {
    /// What a measurement took. One that fails, and all after it, take long
    /// enough to end the calibration.
    fn unless(&self, measure: impl FnOnce() -> Result<Duration, Failure>) -> Duration {
        const LONG: Duration = Duration::from_secs(1);
        if self.0.borrow().is_some() {
            return LONG;
        }
        measure().unwrap_or_else(|why| {
            *self.0.borrow_mut() = Some(why);
            LONG
        })
    }

    fn check(&self) -> Result<(), Failure> {
        self.0.take().map_or(Ok(()), Err)
    }
}

/// Two counts of instructions, and their ratio.
fn instructions(
    bench: &mut Bench,
    row: u8,
    name: &str,
    counts: Option<&Counts>,
    (large, small): &(String, String),
) -> Result<(), Failure> {
    let large = count_of(bench, row, large, counts)?;
    let small = count_of(bench, row, small, counts)?;
    if let (Some(large), Some(small)) = (large, small) {
        let name = format!("{name}, instructions");
        bench.figure(row, &name, large / small, "x", Target::AtMost(1.0));
    }
    Ok(())
}

/// A count of instructions, the most that was seen; `None` where none are
/// counted.
fn count_of(
    bench: &mut Bench,
    row: u8,
    case: &str,
    counts: Option<&Counts>,
) -> Result<Option<f64>, Failure> {
    let Some(counts) = counts else { return Ok(None) };
    let most = counts.of(case).ok_or_else(|| format!("{case} was not counted"))? as f64;
    bench.figure(row, case, most, "instructions", Target::None);
    Ok(Some(most))
}
