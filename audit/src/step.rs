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

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

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
    /// Where it was, and the audit was not.
    #[serde(skip)]
    unseen: BTreeSet<u64>,
}

/// A row's function, and what the audit says of it.
struct Job<'a> {
    row: &'a Row,
    outcome: Outcome,
    start: u64,
}

/// Steps all rows for the object at `path`, on all processors that there are.
///
/// # Errors
/// Where the object cannot be audited. Where a child cannot be traced, or dies,
/// is a violation of its row.
pub fn step(rows: &Rows, image: &Image, path: &Path, effort: Effort) -> Result<Vec<Seen>> {
    host::deepen_stacks()?;
    let stepped = rows.rows.iter().filter(|row| row.step && row.targets.contains(&Isa::X86_64));
    let jobs: Vec<_> = stepped.map(|row| Job::of(row, image)).collect::<Result<_>>()?;
    let bar = ProgressBar::new(jobs.len() as u64)
        .with_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}")?);
    let open = Mutex::new(jobs.iter().enumerate());
    let done = Mutex::new(BTreeMap::new());
    let work = |processor| {
        let pinned = host::stay_on(processor);
        while let Some((at, job)) = taken(&open) {
            bar.set_message(job.row.name.clone());
            let seen = pinned.as_ref().map_or_else(
                |error| Seen::of(job, [format!("{error:#}")]),
                |()| job.seen(path, effort),
            );
            done.lock().unwrap_or_else(PoisonError::into_inner).insert(at, seen);
            bar.inc(1);
        }
    };
    // A child is traced by the thread that started it, and by no other.
    std::thread::scope(|scope| {
        for processor in host::processors()? {
            let work = &work;
            scope.spawn(move || work(processor));
        }
        anyhow::Ok(())
    })?;
    bar.finish_and_clear();
    let mut all = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    all.values_mut().for_each(|seen| seen.name_places(image));
    Ok(all.into_values().collect())
}

/// The next job, if there is one.
fn taken<T>(open: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    open.lock().unwrap_or_else(PoisonError::into_inner).next()
}

impl<'a> Job<'a> {
    fn of(row: &'a Row, image: &Image) -> Result<Self> {
        let start = image.named(&row.symbol).first().map(|function| function.start);
        let start = start.with_context(|| format!("there is no function {}", row.symbol))?;
        Ok(Self { row, outcome: audit(image, row)?, start })
    }

    fn seen(&self, path: &Path, effort: Effort) -> Seen {
        let mut seen = Seen::of(self, []);
        if let Err(error) = self.step(&mut seen, path, effort) {
            seen.violations.push(format!("{error:#}"));
        }
        seen.judge(self.row);
        seen
    }

    fn step(&self, seen: &mut Seen, path: &Path, effort: Effort) -> Result<()> {
        let mut child = Child::start(path, &self.row.symbol, effort.calls)?;
        let mut left = effort.instructions;
        let is_audited = |address| self.outcome.reached.contains(&address);
        while let Some(stopped) = child.next()? {
            let call = stopped.call(self.start, is_audited, left)?;
            seen.take(&self.outcome, &call);
            left = left.saturating_sub(call.counted + call.elsewhere);
            if left == 0 {
                break;
            }
        }
        Ok(())
    }
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
    fn of(job: &Job<'_>, violations: impl IntoIterator<Item = String>) -> Self {
        Self {
            name: job.row.name.clone(),
            bound: job.outcome.instructions,
            most: 0,
            calls: 0,
            violations: violations.into_iter().collect(),
            unseen: BTreeSet::new(),
        }
    }

    fn take(&mut self, outcome: &Outcome, call: &Call) {
        self.most = self.most.max(call.counted);
        self.calls += u64::from(call.is_whole);
        let may_leave = outcome.port.is_some()
            || !outcome.external.is_empty()
            || !outcome.cold.is_empty()
            || !outcome.excused.is_empty();
        self.unseen.extend(call.first_elsewhere.filter(|_| !may_leave));
    }

    fn name_places(&mut self, image: &Image) {
        let unseen = self.unseen.iter().map(|address| {
            format!("executes {}, where the audit has not been", image.place(*address))
        });
        self.violations.extend(unseen);
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
