//! Campaigns: many executions, on all processors, each one checked.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use faregate_planner::trace::Trace;
use parking_lot::Mutex;

use crate::summary::Summary;
use crate::{NotRehearsed, Planner, Setup, rehearse};

/// What came of a campaign.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Sums over all executions.
    pub summary: Summary,
    /// Violations that the checker found, with the seed of their execution: the
    /// first hundred.
    pub violations: Vec<(u64, String)>,
    /// How many there were in all.
    pub violated: u64,
}

/// Executes for each seed what `setup` makes of it, and checks every trace.
///
/// # Errors
/// The first execution that could not be made, with its seed.
pub fn campaign<P: Planner>(
    seeds: std::ops::Range<u64>,
    threads: usize,
    setup: &(impl Fn(u64) -> Setup + Sync),
    planner: &(impl Fn() -> P + Sync),
    check: &(impl Fn(&Setup, &Trace) -> Vec<String> + Sync),
    progress: &(impl Fn(u64) + Sync),
) -> Result<Counts, (u64, NotRehearsed)> {
    let next = AtomicU64::new(seeds.start);
    let done = AtomicU64::new(0);
    let stop = AtomicBool::new(false);
    let counts = Mutex::new(Ok(Counts::default()));
    let work = || {
        let mut planner = planner();
        // Relaxed: each seed is taken once, and the sums are behind the lock.
        while !stop.load(Ordering::Relaxed) {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                break;
            }
            let setup = setup(seed);
            let result = rehearse(&setup, &mut planner).map(|trace| {
                let found = check(&setup, &trace);
                (Summary::of(&setup.plan, &trace), found)
            });
            let mut counts = counts.lock();
            match (result, &mut *counts) {
                (Ok((summary, found)), Ok(counts)) => counts.add(seed, &summary, found),
                (Err(why), Ok(_)) => {
                    *counts = Err((seed, why));
                    stop.store(true, Ordering::Relaxed);
                }
                (_, Err(_)) => {}
            }
            drop(counts);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.max(1) {
            scope.spawn(work);
        }
        work();
    });
    let mut counts = counts.into_inner();
    if let Ok(counts) = &mut counts {
        // Threads come as they come; whoever reads does not.
        counts.violations.sort();
    }
    counts
}

impl Counts {
    fn add(&mut self, seed: u64, summary: &Summary, found: Vec<String>) {
        self.summary.add(summary);
        self.violated += u64::try_from(found.len()).unwrap_or(u64::MAX);
        let room = 100_usize.saturating_sub(self.violations.len());
        self.violations.extend(found.into_iter().take(room).map(|one| (seed, one)));
    }

    /// Whether no execution broke a rule.
    #[must_use]
    pub const fn is_clean(&self) -> bool {
        self.violated == 0
    }
}
