//! The cross-check: random calls, executed one instruction at a time, against
//! the bounds that the audit found.
//!
//! A child process loads the object. Before each call of an audited function it
//! calls the function's `_set_up` with a seed, then stops; the parent steps it
//! through the call. Instructions are counted where the audit has been. Any
//! other one would show that the audit did not see all that can be executed, so
//! it is a violation, unless the row lets the function call what is not
//! audited there: a port, another object, a cold function.

mod host;
#[expect(unsafe_code, reason = "functions of a loaded object are called by address")]
mod sys;

use std::path::Path;

use anyhow::{Context as _, Result};
use indicatif::{ProgressBar, ProgressStyle};

use self::host::Child;
pub use self::sys::host;
use crate::image::Image;
use crate::isa::Isa;
use crate::rows::{Row, Rows};
use crate::walk::{Outcome, audit};

/// How much is tried.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Calls of each function.
    pub calls: u64,
    /// Instructions of each function; where they are used up no new call is
    /// made. A step costs microseconds.
    pub instructions: u64,
}

/// What was seen of a row's function.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Seen {
    /// The row.
    pub name: String,
    /// The bound that the audit found.
    pub bound: u64,
    /// The most instructions of any call.
    pub most: u64,
    /// How many calls were made.
    pub calls: u64,
    /// What contradicts the audit or the row.
    pub violations: Vec<String>,
}

/// Steps all rows for the object at `path`.
///
/// # Errors
/// Where the child cannot be traced, or dies.
pub fn step(rows: &Rows, image: &Image, path: &Path, effort: Effort) -> Result<Vec<Seen>> {
    host::stay_on_one_processor()?;
    let stepped: Vec<_> =
        rows.rows.iter().filter(|row| row.step && row.targets.contains(&Isa::X86_64)).collect();
    let bar = ProgressBar::new(stepped.len() as u64)
        .with_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}")?);
    let mut all = Vec::new();
    for row in stepped {
        bar.set_message(row.name.clone());
        all.push(one(row, image, path, effort).with_context(|| format!("row {:?}", row.name))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

fn one(row: &Row, image: &Image, path: &Path, effort: Effort) -> Result<Seen> {
    let outcome = audit(image, row)?;
    let start = image.named(&row.symbol).first().map(|function| function.start);
    let start = start.with_context(|| format!("there is no function {}", row.symbol))?;
    let mut seen = Seen {
        name: row.name.clone(),
        bound: outcome.instructions,
        most: 0,
        calls: 0,
        violations: Vec::new(),
    };
    let mut child = Child::start(path, &row.symbol, effort.calls)?;
    let mut left = effort.instructions;
    while let Some(stopped) = child.next()? {
        let call = stopped.call(start, |address| outcome.reached.contains(&address), left)?;
        seen.take(&outcome, image, &call);
        left = left.saturating_sub(call.counted + call.elsewhere);
        if left == 0 {
            break;
        }
    }
    seen.judge(row);
    Ok(seen)
}

/// One call, as it was executed.
#[derive(Clone, Copy, Debug)]
struct Call {
    /// Instructions that the audit knows.
    counted: u64,
    /// Instructions that it does not.
    elsewhere: u64,
    /// Where the first of those stands, by the object's own addresses.
    first_elsewhere: Option<u64>,
    /// Whether it came to its end.
    is_whole: bool,
}

impl Seen {
    fn take(&mut self, outcome: &Outcome, image: &Image, call: &Call) {
        self.most = self.most.max(call.counted);
        self.calls += u64::from(call.is_whole);
        let may_leave = outcome.port.is_some()
            || !outcome.external.is_empty()
            || !outcome.cold.is_empty()
            || !outcome.system_calls.is_empty()
            || !outcome.excused.is_empty();
        let unseen = call.first_elsewhere.filter(|_| !may_leave);
        let violation = unseen.map(|address| {
            format!("executes {}, where the audit has not been", image.place(address))
        });
        self.violations.extend(violation.filter(|new| !self.violations.contains(new)));
    }

    fn judge(&mut self, row: &Row) {
        if self.most > self.bound {
            self.violations.push(format!("{} instructions, {} at most", self.most, self.bound));
        }
        if self.calls == 0 {
            self.violations.push("no call came to its end".to_owned());
        }
        if row.reaches_bound && self.most != self.bound {
            self.violations.push(format!(
                "no call reached the bound: {} instructions of {}",
                self.most, self.bound
            ));
        }
    }
}
